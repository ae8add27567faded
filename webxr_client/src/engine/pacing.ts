/** Keeps pictures in time: the budget of points, from the pictures' own times, at desk and in XR. */
import { ALL_POINTS } from '../cloud/points/frame';
import type { Viewer } from '../cloud/picture/viewer';
import { state } from '../store/state';
import { peek } from '../store/watch';
import type { Playback } from './playback';

const DESK_MS = 1000 / 60;
/** Target for software rendering, which is slow but should still follow the hand. */
const SOFTWARE_MS = 1000 / 10;
/** A picture that has stood for so long is drawn whole. */
const REST_MS = 300;

export class Pacing {
  /** Milliseconds that a picture should take in the headset; 0 at the desk. */
  readonly headsetMs = new Float64Array(1);
  /** Off: everything is drawn, however long it takes. */
  adaptive = true;
  private readonly budget = new PointBudget();
  private seen = 0;
  /** The last picture was drawn whole. */
  private whole = false;
  /** Camera and frame as they were, and are. */
  private readonly before = new Float64Array(33);
  private readonly current = new Float64Array(33);
  private readonly movedAt = new Float64Array(1);
  private readonly deskMs: number;
  /** Of the last picture, as the budget takes it. */
  private readonly picture = new Float64Array(3);

  constructor(
    private readonly viewer: Viewer,
    private readonly playback: Playback,
  ) {
    this.deskMs = viewer.software ? SOFTWARE_MS : DESK_MS;
  }

  /** Points that can be drawn in time. */
  get points(): number {
    return this.adaptive ? this.budget.points : ALL_POINTS;
  }

  /** Another display: milliseconds that a picture should take in the headset, 0 at the desk. */
  show(headsetMs: number): void {
    this.headsetMs[0] = headsetMs;
    this.reset();
  }

  /** Another recording. */
  reset(): void {
    this.budget.reset();
  }

  /** Before each picture. */
  update(now: number): void {
    const { viewer } = this;
    const { total } = viewer.intervalMs;
    // A picture of all points at rest does not measure the points that can be drawn in motion.
    if (total !== this.seen && this.adaptive && !this.whole) this.note(now);
    this.seen = total;
    // Light and paint under a still camera change points, not how many there are.
    const moved = this.look() || state.playing.peek();
    if (moved || viewer.renderer.xr.isPresenting) this.movedAt[0] = now;
    const { points } = this;
    this.playback.pointBudget = points === ALL_POINTS ? null : points;
    this.whole = now - this.movedAt[0]! > REST_MS;
    viewer.setLimit(this.whole ? ALL_POINTS : points);
  }

  /** Return whether camera or frame have changed since the last call. */
  private look(): boolean {
    const { current, before } = this;
    const { matrixWorld, projectionMatrix } = this.viewer.camera;
    matrixWorld.toArray(current);
    projectionMatrix.toArray(current, 16);
    current[32] = peek(state.frame);
    let moved = false;
    for (let i = 0; i < current.length; i++) if (current[i] !== before[i]) moved = true;
    if (moved) before.set(current);
    return moved;
  }

  /** Take note of the last picture. */
  private note(now: number): void {
    const { picture, viewer } = this;
    viewer.intervalMs.last(picture);
    picture[1] = this.headsetMs[0]! || this.deskMs;
    picture[2] = now;
    this.budget.note(picture, viewer.drawn);
  }
}

/** A picture later than this many times its target is late; most late ones make it less. */
const LATE = 1.3;
/** Pictures of one decision, or as many as are drawn in this time. */
const WINDOW = 8;
const WINDOW_MS = 600;
const LEAST_PICTURES = 3;
/** After a change the GPU's queue still holds pictures from before: so many, or for so long. */
const SETTLING = 3;
const SETTLING_MS = 250;
const LEAST_CUT = 0.8;
const MOST_CUT = 0.4;
const GROW = 1.3;
/** Milliseconds in time before more points are tried; doubled when that was too many. */
const PATIENCE_MS = 1000;
const LONGEST_PATIENCE_MS = 30_000;
/** A cut that reduces the time of pictures by at most this part had no effect. */
const FASTER = 0.92;
/** Share by which points may take longer where other work takes most of the time. */
const SHARE_OF_REST = 1.5;
/** Fewer would show nothing. */
export const FEWEST_POINTS = 10_000;

/**
 * Budget of points that can be drawn in time: fewer when pictures come too slowly, more again while
 * they come in time. Pure: times of pictures come in.
 */
export class PointBudget {
  /** Points to draw at most, whole; `ALL_POINTS` while nothing is late. */
  points = ALL_POINTS;
  private pictures = 0;
  private late = 0;
  private sum = 0;
  private settling = 0;
  private since = -1;
  private patience = PATIENCE_MS;
  /** More points are being tried since then. */
  private triedAt = -1;
  /** Time of pictures, and the number of their points, when points were last cut. */
  private cutMean = 0;
  private cutDrawn = 0;
  /** The best that can be hoped for: a display at 30 Hz, a slow machine. */
  private floor = 0;

  /** Record a picture of `drawn` points: its duration, target and time, milliseconds. */
  note(picture: Float64Array, drawn: number): void {
    const interval = picture[0]!;
    const target = picture[1]!;
    const now = picture[2]!;
    if (this.since < 0) this.since = now;
    if (this.settling > 0 && now - this.since < SETTLING_MS) {
      this.settling -= 1;
      return;
    }
    this.settling = 0;
    this.pictures += 1;
    this.sum += interval;
    if (interval > LATE * Math.max(target, this.floor)) this.late += 1;
    const enough = this.pictures >= LEAST_PICTURES && this.sum >= WINDOW_MS;
    if (this.pictures < WINDOW && !enough) return;
    const mean = this.sum / this.pictures;
    const slow = this.late > this.pictures / 2;
    this.pictures = this.late = this.sum = 0;
    if (mean < 0.8 * this.floor) this.floor = mean;
    if (slow) this.cut(mean, target, drawn, now);
    else if (now - this.since >= this.patience) this.grow(drawn, now);
  }

  private cut(mean: number, target: number, drawn: number, now: number): void {
    if (this.learnFloor(mean, target, drawn, now)) return;
    this.cutMean = mean;
    this.cutDrawn = drawn;
    const goal = Math.max(target, this.floor);
    // The last try was too much: it is not repeated so soon.
    if (this.triedAt >= 0 && now - this.triedAt < 2 * PATIENCE_MS) {
      this.patience = Math.min(LONGEST_PATIENCE_MS, 2 * this.patience);
    }
    this.triedAt = -1;
    const factor = Math.min(LEAST_CUT, Math.max(MOST_CUT, goal / mean));
    this.points = Math.max(FEWEST_POINTS, Math.round(factor * Math.min(this.points, drawn)));
    this.change(now);
  }

  /** Learn from the last cut how much time is not the points'; true when it was of no use. */
  private learnFloor(mean: number, target: number, drawn: number, now: number): boolean {
    if (this.points <= FEWEST_POINTS) {
      // No points are left to remove: all of the time is other work.
      this.floor = SHARE_OF_REST * mean;
      this.change(now);
      return true;
    }
    if (drawn >= this.cutDrawn) return false;
    if (mean > FASTER * this.cutMean) {
      this.points = this.cutDrawn;
      this.cutDrawn = 0;
      this.floor = mean;
      this.change(now);
      return true;
    }
    const perPoint = (this.cutMean - mean) / (this.cutDrawn - drawn);
    const rest = mean - perPoint * drawn;
    if (rest > 0.8 * target) this.floor = SHARE_OF_REST * rest;
    return false;
  }

  private grow(drawn: number, now: number): void {
    this.begin(now);
    this.cutDrawn = 0;
    if (this.points === ALL_POINTS) return;
    // The last try went well.
    if (this.triedAt >= 0) this.patience = Math.max(PATIENCE_MS, this.patience / 2);
    // A limit far above the number of drawn points is removed.
    this.points = this.points > 4 * drawn ? ALL_POINTS : Math.round(this.points * GROW);
    this.triedAt = now;
    if (this.points === ALL_POINTS) this.patience = PATIENCE_MS;
    this.change(now);
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
    this.points = ALL_POINTS;
    this.patience = PATIENCE_MS;
    this.settling = 0;
    this.since = this.triedAt = -1;
    this.cutDrawn = this.floor = 0;
    this.pictures = this.late = this.sum = 0;
  }
}
