/** The box tool: drag a rectangle over the floor, adjust the box on it, take the points inside. */
import { type Matrix4, Vector3 } from 'three';
import { clip } from '../tools/clip';
import type { CloudFrame } from '../cloud/points/frame';
import { inBox } from '../cloud/points/pick';
import type { Viewer } from '../cloud/picture/viewer';
import { isStroke, state } from '../store/state';
import type { AheadPreview } from '../tools/preview';
import { boxDraft, spanned, standing, toSource, type Volume } from '../tools/volume';
import { brushFor, brushNow } from '../tools/brush';
import type { Strokes } from '../tools/strokes';
import { deskWay } from '../tools/ways';
import { watch } from '../store/watch';
import type { Aim } from '../view/aim';

/** A press that was hardly dragged makes a box so many brush radii wide. */
const CLICKED = 8;

interface BoxToolDeps {
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
  end(): { readonly clicked: boolean } | null {
    const corner = this.corner;
    const frame = this.deps.aim.frame();
    const drawn = boxDraft.peek();
    const least = state.brush.peek().radius;
    this.corner = null;
    if (!corner || !frame) return null;
    const size = CLICKED * least;
    const clicked = drawn === null || Math.max(drawn.size[0], drawn.size[2]) <= least;
    const meant = !clicked
      ? drawn
      : { center: corner.toArray(), size: [size, size, size] as const, yaw: this.yaw() };
    boxDraft.value = fitted(frame, this.deps.viewer.room.matrix, meant);
    return { clicked };
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

  /** Take the points in the box; false without one. */
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

  /** Before each picture: show the points that the box would take. */
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

/** Parts of the points that may be strays below the ground and above an object. */
const [STRAYS_BELOW, STRAYS_ABOVE] = [0.03, 0.003];
/** The ground is searched in a footprint so many times as wide, which includes its surroundings. */
const BESIDE = 1.5;
/** The bottom stands over the ground by this part of the height, at most so many metres. */
const [CLEARANCE, MOST_CLEARANCE] = [0.06, 0.06];
/** A column reaches so many times its wider edge up and down. */
const TALL = 2;
/** Of points on one surface a box is at least so high, as a part of its wider edge. */
const LEAST_HEIGHT = 0.1;
/** A gap of this part of the wider edge ends an object: above it is a ceiling, or a branch. */
const GAP = 0.25;

/** Heights in the room of a frame's points in a box, ascending; `room`: `T_room_local`. */
function heightsIn(frame: CloudFrame, room: Matrix4, volume: Volume): Float64Array {
  const { center, size, quaternion } = toSource(volume, room, [0, 0, 0]);
  const heights: number[] = [];
  const at = new Vector3();
  inBox(frame, center, size, quaternion, (point) => {
    const piece = frame.pieceOf(point);
    if (!piece) return;
    const { words, origin, scale, first } = piece;
    const w = 6 * (point - first);
    at.set(
      origin[0] + words[w]! * scale[0],
      origin[1] + words[w + 1]! * scale[1],
      origin[2] + words[w + 2]! * scale[2],
    );
    heights.push(at.applyMatrix4(room).y);
  });
  return Float64Array.from(heights).sort();
}

/** The box standing on the ground under it, without the ground's own points; itself over nothing. */
function onGround(frame: CloudFrame, room: Matrix4, volume: Volume): Volume {
  const [x, y, z] = volume.size;
  const below: Volume = {
    ...volume,
    center: [volume.center[0], volume.center[1] - y / 2, volume.center[2]],
    size: [BESIDE * x, 2 * Math.max(x, y, z), BESIDE * z],
  };
  const heights = heightsIn(frame, room, below);
  if (heights.length === 0) return volume;
  const ground = heights[Math.floor(STRAYS_BELOW * (heights.length - 1))]!;
  const top = volume.center[1] + y / 2;
  if (top <= ground) return volume;
  return standing(volume, ground + Math.min(MOST_CLEARANCE, CLEARANCE * (top - ground)));
}

/** Return the top of the object on `bottom`, below the first gap. */
function topOf(heights: Float64Array, bottom: number, wide: number): number {
  const last = Math.round((1 - STRAYS_ABOVE) * (heights.length - 1));
  for (let i = 0; i < last; i++) {
    const high = heights[i]! - bottom > LEAST_HEIGHT * wide;
    if (high && heights[i + 1]! - heights[i]! > GAP * wide) return heights[i]!;
  }
  return heights[last]!;
}

/** Return a box over the same footprint, from the ground under it to the top of the object. */
function fitted(frame: CloudFrame, room: Matrix4, volume: Volume): Volume {
  const wide = Math.max(volume.size[0], volume.size[2]);
  const column: Volume = { ...volume, size: [volume.size[0], 2 * TALL * wide, volume.size[2]] };
  const heights = heightsIn(frame, room, column);
  if (heights.length === 0) return volume;
  const bottom = heights[Math.floor(STRAYS_BELOW * (heights.length - 1))]!;
  const height = Math.max(LEAST_HEIGHT * wide, topOf(heights, bottom, wide) - bottom);
  const { center, size } = volume;
  const box: Volume = {
    ...volume,
    center: [center[0], bottom + height / 2, center[2]],
    size: [size[0], height * 1.02, size[2]],
  };
  return onGround(frame, room, box);
}
