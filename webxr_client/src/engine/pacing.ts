/** Keeps pictures in time: the budget of points, from the pictures' own times, at desk and in XR. */
import { ALL_POINTS } from '../cloud/frame';
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
  /** Milliseconds that a picture should take in the headset; 0 at the desk. */
  readonly headsetMs = new Float64Array(1);
  /** Off: everything is drawn, however long it takes. */
  adaptive = true;
  private readonly budget = new PointBudget();
  private seen = 0;
  private changes = 0;
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
    if (total !== this.seen && this.adaptive) this.note(now);
    this.seen = total;
    const moved = viewer.changes !== this.changes || state.playing.peek();
    this.changes = viewer.changes;
    if (moved || viewer.renderer.xr.isPresenting) this.movedAt[0] = now;
    const { points } = this;
    this.playback.pointBudget = points === ALL_POINTS ? null : points;
    viewer.setLimit(now - this.movedAt[0]! > REST_MS ? ALL_POINTS : points);
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
