/** Picking by a ray or a ball among the points on the page; blocks of points are culled whole. */
import { Matrix4, Quaternion } from 'three';
import type { Vec } from '../../store/types';
import { BLOCK } from './blocks';
import { shows } from './clipping';
import { densityFactor, type CloudFrame } from './frame';
import { blocksOf, DELETED, isHidden, spacingAt, type Piece } from './piece';

export interface Hit {
  /** Metres along the (unit) ray. */
  readonly distance: number;
  /** Stored number of the point met. */
  readonly point: number;
  readonly position: [number, number, number];
}

/** Whether no point of a piece can be met: its sensor is hidden, or the ray passes its box. */
function misses(piece: Piece): boolean {
  return isHidden(piece) || !boxMeetsRay(piece.lo, piece.hi);
}

/**
 * Return the place in which a ray first meets the surface, or null.  Local coordinates, `direction` of unit length.
 *
 * As on the server: a point counts as met when the ray passes it within about the cloud's own
 * spacing there, never farther than `radius`; where nothing is that near, `radius` decides.
 * `clip`: `T_cube_local` of the box outside which nothing is met.  `edit`: see `labelOf`.
 */
export function firstHit(
  frame: CloudFrame,
  origin: Vec,
  direction: Vec,
  radius: number,
  visible: (label: number) => boolean = notDeleted,
  clip: Matrix4 | null = null,
  edit?: string,
): Hit | null {
  let near = Infinity;
  let nearPoint = -1;
  let wide = Infinity;
  let widePoint = -1;
  const [ox, oy, oz] = origin;
  const [dx, dy, dz] = direction;
  from.set(origin);
  way.set(direction);
  measures[RADIUS] = radius;
  for (let number = 0; number < frame.pieces.length; number++) {
    const piece = frame.pieces[number]!;
    if (misses(piece)) continue;
    const factor = densityFactor(frame, piece);
    const { words } = piece;
    const blocks = blocksOf(piece);
    for (let block = 0, first = 0; first < piece.count; block++, first += BLOCK) {
      blockBounds(piece, blocks, block);
      if (!boxMeetsRay(lo, hi)) continue;
      const spacing = spacingAt(piece, first, factor);
      const reach = Math.min(radius, Math.max(0.05 * radius, 1.5 * spacing));
      const stop = Math.min(piece.count, first + BLOCK);
      for (let i = first, w = first * 6; i < stop; i++, w += 6) {
        const x = piece.origin[0] + words[w]! * piece.scale[0] - ox;
        const y = piece.origin[1] + words[w + 1]! * piece.scale[1] - oy;
        const z = piece.origin[2] + words[w + 2]! * piece.scale[2] - oz;
        const along = x * dx + y * dy + z * dz;
        if (along <= 0 || along >= near) continue;
        const off = x * x + y * y + z * z - along * along;
        if (off > radius * radius || !visible(frame.labelOf(piece.first + i, edit))) continue;
        if (clip !== null && !shows(clip, x + ox, y + oy, z + oz)) continue;
        if (off <= reach * reach && along < near) {
          near = along;
          nearPoint = piece.first + i;
        }
        if (along < wide) {
          wide = along;
          widePoint = piece.first + i;
        }
      }
    }
  }
  const distance = nearPoint >= 0 ? near : wide;
  const point = nearPoint >= 0 ? nearPoint : widePoint;
  if (point < 0) return null;
  return {
    distance,
    point,
    position: [ox + dx * distance, oy + dy * distance, oz + dz * distance],
  };
}

function notDeleted(label: number): boolean {
  return label !== DELETED;
}

/** Call `found` with each point within `radius` of the segment from `a` to `b`, inside `clip`. */
export function inCapsule(
  frame: CloudFrame,
  a: Vec,
  b: Vec,
  radius: number,
  found: (point: number) => void,
  clip: Matrix4 | null = null,
): void {
  for (let k = 0; k < 3; k++) {
    from[k] = a[k]!;
    way[k] = b[k]! - a[k]!;
    min[k] = Math.min(a[k]!, b[k]!) - radius;
    max[k] = Math.max(a[k]!, b[k]!) + radius;
  }
  measures[RADIUS] = radius;
  measures[LENGTH2] = way[0]! * way[0]! + way[1]! * way[1]! + way[2]! * way[2]!;
  eachPoint(frame, boxMeetsBounds, capsuleHolds, found, clip);
}

/** Call `found` with each point within `radius` of the half-line. */
export function alongRay(
  frame: CloudFrame,
  origin: Vec,
  direction: Vec,
  radius: number,
  found: (point: number) => void,
  clip: Matrix4 | null = null,
): void {
  for (let k = 0; k < 3; k++) {
    from[k] = origin[k]!;
    way[k] = direction[k]!;
  }
  measures[RADIUS] = radius;
  eachPoint(frame, boxMeetsRay, rayHolds, found, clip);
}

/** Call `found` with each point in a box: full edges `size`, turned by a quaternion x, y, z, w. */
export function inBox(
  frame: CloudFrame,
  center: Vec,
  size: Vec,
  quaternion: readonly [number, number, number, number],
  found: (point: number) => void,
  clip: Matrix4 | null = null,
): void {
  const matrix = new Matrix4().makeRotationFromQuaternion(new Quaternion(...quaternion)).elements;
  for (let k = 0; k < 3; k++) {
    from[k] = center[k]!;
    halves[k] = size[k]! / 2;
    for (let axis = 0; axis < 3; axis++) axes[3 * axis + k] = matrix[4 * axis + k]!;
  }
  for (let k = 0; k < 3; k++) {
    let reach = 0;
    for (let axis = 0; axis < 3; axis++) reach += Math.abs(axes[3 * axis + k]!) * halves[axis]!;
    min[k] = from[k]! - reach;
    max[k] = from[k]! + reach;
  }
  eachPoint(frame, boxMeetsBounds, boxHolds, found, clip);
}

function boxHolds(): boolean {
  const x = at[0]! - from[0]!;
  const y = at[1]! - from[1]!;
  const z = at[2]! - from[2]!;
  for (let axis = 0; axis < 3; axis++) {
    const along = x * axes[3 * axis]! + y * axes[3 * axis + 1]! + z * axes[3 * axis + 2]!;
    if (Math.abs(along) > halves[axis]!) return false;
  }
  return true;
}

// The thing looked for, and the state of the search.  All of it stays in typed arrays: V8 would box
// each fractional number that is handed on, three for every point that is looked at.
const from = new Float64Array(3);
const way = new Float64Array(3);
const min = new Float64Array(3);
const max = new Float64Array(3);
/** Of a box: its axes one after another, and half its edges. */
const axes = new Float64Array(9);
const halves = new Float64Array(3);
const measures = new Float64Array(2);
const [RADIUS, LENGTH2] = [0, 1] as const;
const lo = new Float64Array(3);
const hi = new Float64Array(3);
const at = new Float64Array(3);

type Corner = ArrayLike<number>;

/** Call `found` with the points that `holds` of all blocks that `meets`. */
function eachPoint(
  frame: CloudFrame,
  meets: (boxLo: Corner, boxHi: Corner) => boolean,
  holds: () => boolean,
  found: (point: number) => void,
  clip: Matrix4 | null = null,
): void {
  for (let number = 0; number < frame.pieces.length; number++) {
    const piece = frame.pieces[number]!;
    if (isHidden(piece) || !meets(piece.lo, piece.hi)) continue;
    const { words, origin, scale } = piece;
    const blocks = blocksOf(piece);
    for (let block = 0, first = 0; first < piece.count; block++, first += BLOCK) {
      blockBounds(piece, blocks, block);
      if (!meets(lo, hi)) continue;
      const stop = Math.min(piece.count, first + BLOCK);
      for (let i = first, w = first * 6; i < stop; i++, w += 6) {
        at[0] = origin[0] + words[w]! * scale[0];
        at[1] = origin[1] + words[w + 1]! * scale[1];
        at[2] = origin[2] + words[w + 2]! * scale[2];
        if (!holds() || (clip !== null && !shows(clip, at[0], at[1], at[2]))) continue;
        found(piece.first + i);
      }
    }
  }
}

function capsuleHolds(): boolean {
  let x = at[0]! - from[0]!;
  let y = at[1]! - from[1]!;
  let z = at[2]! - from[2]!;
  const length2 = measures[LENGTH2]!;
  if (length2 > 0) {
    const along = (x * way[0]! + y * way[1]! + z * way[2]!) / length2;
    const t = Math.min(1, Math.max(0, along));
    x -= t * way[0]!;
    y -= t * way[1]!;
    z -= t * way[2]!;
  }
  return x * x + y * y + z * z <= measures[RADIUS]! * measures[RADIUS]!;
}

function rayHolds(): boolean {
  const x = at[0]! - from[0]!;
  const y = at[1]! - from[1]!;
  const z = at[2]! - from[2]!;
  const along = x * way[0]! + y * way[1]! + z * way[2]!;
  const off = x * x + y * y + z * z - along * along;
  return along >= 0 && off <= measures[RADIUS]! * measures[RADIUS]!;
}

function blockBounds(piece: Piece, blocks: Uint16Array, block: number): void {
  for (let k = 0; k < 3; k++) {
    lo[k] = piece.origin[k]! + blocks[block * 6 + k]! * piece.scale[k]!;
    hi[k] = piece.origin[k]! + blocks[block * 6 + 3 + k]! * piece.scale[k]!;
  }
}

function boxMeetsBounds(boxLo: Corner, boxHi: Corner): boolean {
  return (
    min[0]! <= boxHi[0]! && max[0]! >= boxLo[0]! &&
    min[1]! <= boxHi[1]! && max[1]! >= boxLo[1]! &&
    min[2]! <= boxHi[2]! && max[2]! >= boxLo[2]!
  ); // prettier-ignore
}

/** Whether the half-line enters a box grown by the radius (slab method). */
function boxMeetsRay(boxLo: Corner, boxHi: Corner): boolean {
  const radius = measures[RADIUS]!;
  let enter = 0;
  let leave = Infinity;
  for (let k = 0; k < 3; k++) {
    const d = way[k]!;
    const a = boxLo[k]! - radius - from[k]!;
    const b = boxHi[k]! + radius - from[k]!;
    if (Math.abs(d) < 1e-12) {
      if (a > 0 || b < 0) return false;
      continue;
    }
    const s = a / d;
    const t = b / d;
    enter = Math.max(enter, Math.min(s, t));
    leave = Math.min(leave, Math.max(s, t));
  }
  return leave >= enter;
}
