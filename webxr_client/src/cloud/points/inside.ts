/** Points of a frame that a camera sees inside an outline; as the server finds them. */
import type { Matrix4 } from 'three';
import { BLOCK } from './blocks';
import { shows } from './clipping';
import type { CloudFrame } from './frame';
import { blocksOf, isHidden, type Piece } from './piece';

/** Corners in normalised device coordinates, x right and y up. */
export type Outline = readonly (readonly [number, number])[];

/** A corner of a box in clip coordinates: x, y, w. */
const corner = new Float64Array(3);

/**
 * Call `found` with each point inside `outline` (even-odd rule).  `clip`: row-major
 * `clip_from_local`; points behind the camera's near plane or outside `box` (`T_cube_local`) are
 * never taken.
 */
export function insideOutline(
  frame: CloudFrame,
  outline: Outline,
  clip: readonly number[],
  found: (point: number) => void,
  box: Matrix4 | null = null,
): void {
  const [left, right] = span(outline, 0);
  const [low, high] = span(outline, 1);
  const bounds = [left, right, low, high] as const;
  for (const piece of frame.pieces) {
    if (isHidden(piece)) continue;
    const { words, origin, scale } = piece;
    const blocks = blocksOf(piece);
    for (let block = 0, first = 0; first < piece.count; block++, first += BLOCK) {
      if (isOutside(piece, blocks, block, clip, bounds)) continue;
      const stop = Math.min(piece.count, first + BLOCK);
      for (let i = first, w = first * 6; i < stop; i++, w += 6) {
        const x = origin[0] + words[w]! * scale[0];
        const y = origin[1] + words[w + 1]! * scale[1];
        const z = origin[2] + words[w + 2]! * scale[2];
        const depth = clip[12]! * x + clip[13]! * y + clip[14]! * z + clip[15]!;
        const u = (clip[0]! * x + clip[1]! * y + clip[2]! * z + clip[3]!) / depth;
        if (depth <= 0 || u < left || u > right) continue;
        const v = (clip[4]! * x + clip[5]! * y + clip[6]! * z + clip[7]!) / depth;
        if (v < low || v > high) continue;
        const near = clip[8]! * x + clip[9]! * y + clip[10]! * z + clip[11]!;
        if (near < -depth || !holds(outline, u, v)) continue;
        if (box === null || shows(box, x, y, z)) found(piece.first + i);
      }
    }
  }
}

/** Whether an outline encloses a place: an edge counts when it crosses the line to the right. */
export function holds(outline: Outline, x: number, y: number): boolean {
  let inside = false;
  let [ax, ay] = outline.at(-1)!;
  for (const [bx, by] of outline) {
    if (ay > y !== by > y && x < ((bx - ax) * (y - ay)) / (by - ay) + ax) inside = !inside;
    ax = bx;
    ay = by;
  }
  return inside;
}

function span(outline: Outline, axis: 0 | 1): [number, number] {
  let low = Infinity;
  let high = -Infinity;
  for (const place of outline) {
    low = Math.min(low, place[axis]);
    high = Math.max(high, place[axis]);
  }
  return [low, high];
}

/** Whether all corners of a block lie on the outer side of one edge of the outline's bounds. */
function isOutside(
  piece: Piece,
  blocks: Uint16Array,
  block: number,
  clip: readonly number[],
  [left, right, low, high]: readonly [number, number, number, number],
): boolean {
  let sides = 31;
  for (let k = 0; k < 8 && sides !== 0; k++) {
    cornerOf(piece, blocks, block, k, clip);
    const [x, y, w] = corner as unknown as [number, number, number];
    sides &=
      (x > right * w ? 1 : 0) |
      (x < left * w ? 2 : 0) |
      (y > high * w ? 4 : 0) |
      (y < low * w ? 8 : 0) |
      (w <= 0 ? 16 : 0);
  }
  return sides !== 0;
}

function cornerOf(
  { origin, scale }: Piece,
  blocks: Uint16Array,
  block: number,
  k: number,
  clip: readonly number[],
): void {
  const at = (axis: 0 | 1 | 2): number =>
    origin[axis] + blocks[block * 6 + axis + (k & (1 << axis) ? 3 : 0)]! * scale[axis];
  const [x, y, z] = [at(0), at(1), at(2)];
  corner[0] = clip[0]! * x + clip[1]! * y + clip[2]! * z + clip[3]!;
  corner[1] = clip[4]! * x + clip[5]! * y + clip[6]! * z + clip[7]!;
  corner[2] = clip[12]! * x + clip[13]! * y + clip[14]! * z + clip[15]!;
}
