/** The box tool: drag a rectangle over the floor, adjust the box on it, and take what is inside. */
import { Vector3 } from 'three';
import { isStroke, state } from '../state';
import type { AheadPreview } from '../tools/ahead';
import { boxDraft } from '../tools/box-draft';
import { brushFor, brushNow } from '../tools/brush';
import type { Strokes } from '../tools/strokes';
import { deskWay } from '../tools/ways';
import type { Viewer } from '../cloud/viewer';
import { fitted, onGround } from '../volume/heights';
import { spanned, toSource, type Volume } from '../volume/volume';
import { watch } from '../watch';
import { clip } from '../clip';
import type { Aim } from './aim';

/** A press that was hardly dragged makes a box so many brush radii wide. */
const CLICKED = 8;

export interface BoxToolDeps {
  readonly viewer: Viewer;
  readonly aim: Aim;
  readonly strokes: Strokes;
  readonly ahead: AheadPreview;
}

export class BoxTool {
  /** First corner of the rectangle, room coordinates. */
  private corner: Vector3 | null = null;
  private dirty = false;
  private shows = false;

  constructor(private readonly deps: BoxToolDeps) {
    watch([state.sequence, state.brush], () => {
      if (state.sequence.peek() === null || state.brush.peek().shape !== 'box') this.drop();
    });
    const { frame, palette, activeLabel, tool, shown } = state;
    watch([boxDraft, clip, frame, palette, activeLabel, tool, shown, state.brush], () => {
      this.dirty = true;
      this.deps.viewer.invalidate();
    });
  }

  /** Begin a rectangle where the cursor meets the recording; false where it meets nothing. */
  begin(): boolean {
    const { aim } = this.deps;
    const hit = aim.hit(state.brush.peek().radius);
    if (!hit) return false;
    this.corner = aim.roomPosition(hit);
    return true;
  }

  /** The rectangle's other corner is under the cursor. */
  stretch(): void {
    const box = this.rectangle();
    if (box) boxDraft.value = box;
  }

  /** The rectangle is drawn: a box stands on it. */
  end(): void {
    const corner = this.corner;
    const frame = this.deps.aim.frame();
    const drawn = boxDraft.peek();
    const least = state.brush.peek().radius;
    this.corner = null;
    if (!corner || !frame) return;
    const size = CLICKED * least;
    const meant =
      drawn !== null && Math.max(drawn.size[0], drawn.size[2]) > least
        ? drawn
        : { center: corner.toArray(), size: [size, size, size] as const, yaw: this.yaw() };
    boxDraft.value = fitted(frame, this.deps.viewer.room.matrix, meant);
  }

  private rectangle(): Volume | null {
    const { corner } = this;
    const ray = this.deps.aim.roomRay();
    if (!corner) return null;
    const far = (corner.y - ray.origin.y) / ray.direction.y;
    // Beyond the horizon there is no floor.
    if (!Number.isFinite(far) || far <= 0) return null;
    const other = ray.at(far, new Vector3());
    return spanned(corner, other, this.yaw(), corner.y, 0);
  }

  /** As the eye is turned, so that a rectangle on screen is one on the floor. */
  private yaw(): number {
    const right = new Vector3().setFromMatrixColumn(this.deps.viewer.camera.matrixWorld, 0);
    return Math.atan2(-right.z, right.x);
  }

  /** Put the box on the ground under it. */
  snap(): boolean {
    const frame = this.deps.aim.frame();
    const draft = boxDraft.peek();
    if (!frame || !draft) return false;
    boxDraft.value = onGround(frame, this.deps.viewer.room.matrix, draft);
    return true;
  }

  /** Take what is in the box; false without one. */
  apply(): boolean {
    const draft = boxDraft.peek();
    const frame = this.deps.aim.frame();
    const info = state.sequence.peek();
    if (!draft || !frame || !info) return false;
    const brush = brushFor(deskWay(), state.brush.peek().radius);
    if (!brush) return true;
    this.drop();
    const box = toSource(draft, this.deps.viewer.room.matrix, info.shift);
    this.deps.strokes.begin(frame, { ...brush, ...box }, info.shift).end();
    return true;
  }

  /** Give it up; false without one. */
  drop(): boolean {
    this.corner = null;
    if (boxDraft.peek() === null) return false;
    boxDraft.value = null;
    return true;
  }

  /** Before each picture: show what it would take. */
  update(): void {
    if (!this.dirty) return;
    this.dirty = false;
    const draft = boxDraft.peek();
    const frame = this.deps.aim.frame();
    const info = state.sequence.peek();
    const way = deskWay();
    const takes = draft !== null && way.name === 'box' && isStroke(state.tool.peek());
    const brush = takes ? brushNow(way, state.brush.peek().radius) : null;
    if (!draft || !frame || !info || !brush) {
      if (this.shows) this.deps.ahead.hide();
      this.shows = false;
      return;
    }
    this.shows = true;
    const box = toSource(draft, this.deps.viewer.room.matrix, info.shift);
    this.deps.ahead.show(frame, { ...brush, ...box });
  }
}
