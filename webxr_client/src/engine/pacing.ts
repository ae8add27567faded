/** Keeps pictures in time: the budget of points, from the pictures' own times, at desk and in XR. */
import type { Viewer } from '../cloud/viewer';
import { state } from '../state';
import { PointBudget } from './budget';
import type { Playback } from './playback';

const DESK_MS = 1000 / 60;
/** A program that stands in for a GPU is never that fast; it should still follow the hand. */
const SOFTWARE_MS = 1000 / 10;
/** A picture that has stood for so long is drawn whole. */
const REST_MS = 300;

export class Pacing {
  /** Milliseconds that a picture should take in the headset, or null at the desk. */
  headsetMs: number | null = null;
  /** Off: everything is drawn, however long it takes. */
  adaptive = true;
  private readonly budget = new PointBudget();
  private seen = 0;
  private changes = 0;
  private movedAt = 0;

  constructor(
    private readonly viewer: Viewer,
    private readonly playback: Playback,
  ) {}

  /** Points that can be drawn in time. */
  get points(): number {
    return this.adaptive ? this.budget.points : Infinity;
  }

  get targetMs(): number {
    return this.headsetMs ?? (this.viewer.software ? SOFTWARE_MS : DESK_MS);
  }

  /** Another display, or another recording. */
  reset(headsetMs = this.headsetMs): void {
    this.headsetMs = headsetMs;
    this.budget.reset();
  }

  /** Before each picture. */
  update(now: number): void {
    const { viewer } = this;
    const { total, last } = viewer.intervalMs;
    if (total !== this.seen && this.adaptive) {
      this.budget.note(last, this.targetMs, viewer.drawn, now);
    }
    this.seen = total;
    const moved = viewer.changes !== this.changes || state.playing.peek();
    this.changes = viewer.changes;
    if (moved || viewer.renderer.xr.isPresenting) this.movedAt = now;
    const points = Math.round(this.points);
    this.playback.pointBudget = points === Infinity ? null : points;
    viewer.setLimit(now - this.movedAt > REST_MS ? Infinity : points);
  }
}
