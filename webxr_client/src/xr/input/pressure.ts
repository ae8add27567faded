/**
 * The trigger as pressure: half pressed it paints with half the sphere, fully pressed with all of
 * it.  A quick full press must not begin with a small stroke: the level is decided a moment after
 * the trigger leaves its rest, or as soon as it is full.
 */
const REST = 0.1;
const FULL = 0.75;
const SLACK = 0.5;
const DECIDE_MS = 70;
/** On its way up the trigger passes the middle: only staying there means half. */
const SETTLE_MS = 200;

export type Level = 0 | 0.5 | 1;

export class Pressure {
  level: Level = 0;
  private since = -1;

  update(value: number, now: number): Level {
    if (value < REST) {
      // A tap shorter than the decision is a dab at half size.
      const tapped = this.level === 0 && this.since >= 0;
      this.since = -1;
      this.level = tapped ? 0.5 : 0;
    } else if (this.level === 0) {
      if (this.since < 0) this.since = now;
      if (value >= FULL) this.decide(1);
      else if (now - this.since >= DECIDE_MS) this.decide(0.5);
    } else if (this.level === 0.5) {
      if (value >= FULL) this.decide(1);
    } else if (value >= SLACK) {
      this.since = -1;
    } else if (this.since < 0) {
      this.since = now;
    } else if (now - this.since >= SETTLE_MS) {
      this.decide(0.5);
    }
    return this.level;
  }

  private decide(level: Level): void {
    this.level = level;
    this.since = -1;
  }
}
