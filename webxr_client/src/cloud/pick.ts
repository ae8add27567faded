/** What a ray or a ball meets among the points on the page; blocks of points are culled whole. */
import { BLOCK } from './blocks';
import { blocksOf, DELETED, densityFactor, spacingAt, type CloudFrame, type Piece } from './frame';

export type Vec = readonly [number, number, number];

export interface Hit {
  /** Metres along the (unit) ray. */
  readonly distance: number;
  /** Stored number of the point met. */
  readonly point: number;
  readonly position: [number, number, number];
}

/**
 * Where a ray first meets the surface, or null.  Local coordinates, `direction` of unit length.
 *
 * As on the server: a point counts as met when the ray passes it within about the cloud's own
 * spacing there, never farther than `radius`; where nothing is that near, `radius` decides.
 */
export function firstHit(
  frame: CloudFrame,
  origin: Vec,
  direction: Vec,
  radius: number,
  visible: (label: number) => boolean = notDeleted,
): Hit | null {
  let near = Infinity;
  let nearPoint = -1;
  let wide = Infinity;
  let widePoint = -1;
  const [ox, oy, oz] = origin;
  const [dx, dy, dz] = direction;
  for (let at = 0; at < frame.pieces.length; at++) {
    const piece = frame.pieces[at]!;
    if (!rayMeets(origin, direction, piece.lo, piece.hi, radius)) continue;
    const factor = densityFactor(frame, piece);
    const { words } = piece;
    const blocks = blocksOf(piece);
    for (let block = 0, first = 0; first < piece.count; block++, first += BLOCK) {
      blockBounds(piece, blocks, block);
      if (!rayMeets(origin, direction, lo, hi, radius)) continue;
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
        if (off > radius * radius || !visible(frame.labelOf(piece.first + i))) continue;
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

/** Call `found` with each point within `radius` of the segment from `a` to `b`. */
export function inCapsule(
  frame: CloudFrame,
  a: Vec,
  b: Vec,
  radius: number,
  found: (point: number) => void,
): void {
  const min: [number, number, number] = [0, 0, 0];
  const max: [number, number, number] = [0, 0, 0];
  for (let k = 0; k < 3; k++) {
    min[k] = Math.min(a[k]!, b[k]!) - radius;
    max[k] = Math.max(a[k]!, b[k]!) + radius;
  }
  const ax = b[0] - a[0];
  const ay = b[1] - a[1];
  const az = b[2] - a[2];
  const length2 = ax * ax + ay * ay + az * az;
  const square = radius * radius;
  eachNear(
    frame,
    (boxLo, boxHi) => boxesMeet(min, max, boxLo, boxHi),
    (point, px, py, pz) => {
      let x = px - a[0];
      let y = py - a[1];
      let z = pz - a[2];
      if (length2 > 0) {
        const t = Math.min(1, Math.max(0, (x * ax + y * ay + z * az) / length2));
        x -= t * ax;
        y -= t * ay;
        z -= t * az;
      }
      if (x * x + y * y + z * z <= square) found(point);
    },
  );
}

/** Call `found` with each point within `radius` of the half-line. */
export function alongRay(
  frame: CloudFrame,
  origin: Vec,
  direction: Vec,
  radius: number,
  found: (point: number) => void,
): void {
  const square = radius * radius;
  eachNear(
    frame,
    (boxLo, boxHi) => rayMeets(origin, direction, boxLo, boxHi, radius),
    (point, px, py, pz) => {
      const x = px - origin[0];
      const y = py - origin[1];
      const z = pz - origin[2];
      const along = x * direction[0] + y * direction[1] + z * direction[2];
      if (along >= 0 && x * x + y * y + z * z - along * along <= square) found(point);
    },
  );
}

/** Visit the points of every block that `meets`. */
export function eachNear(
  frame: CloudFrame,
  meets: (lo: Vec, hi: Vec) => boolean,
  visit: (point: number, x: number, y: number, z: number) => void,
): void {
  for (const piece of frame.pieces) {
    if (!meets(piece.lo, piece.hi)) continue;
    const { words, origin, scale } = piece;
    const blocks = blocksOf(piece);
    for (let block = 0, first = 0; first < piece.count; block++, first += BLOCK) {
      blockBounds(piece, blocks, block);
      if (!meets(lo, hi)) continue;
      const stop = Math.min(piece.count, first + BLOCK);
      for (let i = first, w = first * 6; i < stop; i++, w += 6) {
        visit(
          piece.first + i,
          origin[0] + words[w]! * scale[0],
          origin[1] + words[w + 1]! * scale[1],
          origin[2] + words[w + 2]! * scale[2],
        );
      }
    }
  }
}

const lo: [number, number, number] = [0, 0, 0];
const hi: [number, number, number] = [0, 0, 0];

function blockBounds(piece: Piece, blocks: Uint16Array, block: number): void {
  for (let k = 0; k < 3; k++) {
    lo[k] = piece.origin[k]! + blocks[block * 6 + k]! * piece.scale[k]!;
    hi[k] = piece.origin[k]! + blocks[block * 6 + 3 + k]! * piece.scale[k]!;
  }
}

function boxesMeet(aLo: Vec, aHi: Vec, bLo: Vec, bHi: Vec): boolean {
  return (
    aLo[0] <= bHi[0] && aHi[0] >= bLo[0] &&
    aLo[1] <= bHi[1] && aHi[1] >= bLo[1] &&
    aLo[2] <= bHi[2] && aHi[2] >= bLo[2]
  ); // prettier-ignore
}

/** Whether a half-line enters a box grown by `radius` (slab method). */
function rayMeets(origin: Vec, direction: Vec, boxLo: Vec, boxHi: Vec, radius: number): boolean {
  let enter = 0;
  let leave = Infinity;
  for (let k = 0; k < 3; k++) {
    const d = direction[k]!;
    const a = boxLo[k]! - radius - origin[k]!;
    const b = boxHi[k]! + radius - origin[k]!;
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
