/**
 * How many points can be drawn in time: fewer when pictures come too slowly, more again while they
 * come in time.  Pure: times of pictures come in.
 */

/** A picture later than this many times its target is late; most late ones make it less. */
const LATE = 1.3;
/** Pictures that are looked at together, or as many as come in this time. */
const WINDOW = 8;
const WINDOW_MS = 600;
/** After a change the GPU's queue still holds pictures from before. */
const SETTLING = 3;
const LEAST_CUT = 0.8;
const MOST_CUT = 0.4;
const GROW = 1.3;
/** Milliseconds in time before more points are tried; doubled when that was too many. */
const PATIENCE_MS = 1000;
const LONGEST_PATIENCE_MS = 30_000;
/** Cuts that made no picture faster by this part, one after another: points are not to blame. */
const USELESS_CUTS = 3;
const FASTER = 0.92;
/** Fewer would show nothing. */
export const FEWEST_POINTS = 10_000;

export class PointBudget {
  /** Points to draw at most; `Infinity` while nothing is late. */
  points = Infinity;
  private pictures = 0;
  private late = 0;
  private sum = 0;
  private settling = 0;
  private since = -1;
  private patience = PATIENCE_MS;
  /** More points are being tried since then. */
  private triedAt = -1;
  /** What pictures took when points were last cut, and how often that changed nothing. */
  private cutMean = Infinity;
  private useless = 0;
  /** The time of a picture that no number of points explains (a display at 30 Hz). */
  private floor = 0;

  /** A picture of `drawn` points took `interval` of the `target` milliseconds; true on a change. */
  note(interval: number, target: number, drawn: number, now: number): boolean {
    if (this.settling > 0) {
      this.settling -= 1;
      this.begin(now);
      return false;
    }
    if (this.pictures === 0 && this.since < 0) this.since = now;
    this.pictures += 1;
    this.sum += interval;
    if (interval > LATE * Math.max(target, this.floor)) this.late += 1;
    if (this.pictures < WINDOW && this.sum < WINDOW_MS) return false;
    const mean = this.sum / this.pictures;
    const slow = this.late > this.pictures / 2;
    this.pictures = this.late = this.sum = 0;
    if (mean < 0.8 * this.floor) this.floor = 0;
    if (slow) return this.cut(mean, target, drawn, now);
    return now - this.since >= this.patience && this.grow(drawn, now);
  }

  private cut(mean: number, target: number, drawn: number, now: number): boolean {
    this.useless = mean > FASTER * this.cutMean ? this.useless + 1 : 0;
    if (this.useless === USELESS_CUTS) {
      this.reset();
      this.floor = mean;
      return true;
    }
    this.cutMean = mean;
    // What was just tried was too much: it is not tried again so soon.
    if (this.triedAt >= 0 && now - this.triedAt < 2 * PATIENCE_MS) {
      this.patience = Math.min(LONGEST_PATIENCE_MS, 2 * this.patience);
    }
    this.triedAt = -1;
    const before = this.points;
    const factor = Math.min(LEAST_CUT, Math.max(MOST_CUT, target / mean));
    this.points = Math.max(FEWEST_POINTS, factor * Math.min(before, drawn));
    this.change(now);
    return this.points !== before;
  }

  private grow(drawn: number, now: number): boolean {
    this.begin(now);
    this.cutMean = Infinity;
    this.useless = 0;
    if (this.points === Infinity) return false;
    // A limit far above what there is to draw is none.
    this.points = this.points > 4 * drawn ? Infinity : this.points * GROW;
    this.triedAt = now;
    if (this.points === Infinity) this.patience = PATIENCE_MS;
    this.change(now);
    return true;
  }

  private change(now: number): void {
    this.settling = SETTLING;
    this.begin(now);
  }

  private begin(now: number): void {
    this.since = now;
    this.pictures = this.late = this.sum = 0;
  }

  /** Another display, another recording: begin without a limit. */
  reset(): void {
    this.points = Infinity;
    this.patience = PATIENCE_MS;
    this.settling = 0;
    this.since = this.triedAt = -1;
    this.cutMean = Infinity;
    this.useless = this.floor = 0;
    this.pictures = this.late = this.sum = 0;
  }
}
