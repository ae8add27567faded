/** Pixels and their depths → points on a grid of 16 bits, as chunks of points have them. */
import { sizeCode, MAX_CHUNKS, SIZE_CODES, WORDS } from '../chunk/segment';
import type { Lattice } from '../../protocol/messages';
import { FARTHEST, type Band } from './lattice';

type Vector = readonly [number, number, number];

/** The depth's own along the camera's axis, across it the recording's box in 65,535 cells. */
export interface Grid {
  readonly origin: Vector;
  readonly scale: Vector;
}

/** `1 << SIZE_SHIFT` depths share a size. */
const SIZE_SHIFT = 5;
/** Surfaces are seen askew, most of them by so much: their points lie farther apart. */
export const SLANT = 1.15;

export function gridOf(lattice: Lattice, lo: Vector, hi: Vector): Grid {
  const { axis, sign, eye, unit } = lattice;
  const start = sign > 0 ? eye[axis]! : eye[axis]! - FARTHEST * unit;
  const along = (side: number, own: number, other: number) => (side === axis ? own : other);
  const origin = [0, 1, 2].map((side) => along(side, start, lo[side]!));
  const scale = [0, 1, 2].map((side) =>
    along(side, unit, Math.max((hi[side]! - lo[side]!) / FARTHEST, 1e-9)),
  );
  return { origin, scale } as unknown as Grid;
}

/** The axes that columns and rows go along. */
export function sidesOf({ axis }: Lattice): [number, number] {
  return axis === 0 ? [1, 2] : axis === 1 ? [0, 2] : [0, 1];
}

/**
 * Return the words of a chunk's points (see `Piece`), without colours.  `pixels` are row-major,
 * `depths` are of the whole image.
 */
export function unproject(
  lattice: Lattice,
  { origin, scale }: Grid,
  chunk: number,
  band: Band,
  pixels: Uint32Array,
  depths: Uint16Array,
): Uint16Array<ArrayBuffer> {
  const { width, height, axis, sign, eye, unit, tangent, pitch } = lattice;
  const [a, b] = sidesOf(lattice);
  const rays = (side: number, i: 0 | 1, count: number) =>
    Float64Array.from(
      { length: count },
      (_, k) => (unit * (tangent[i] + pitch[i] * k)) / scale[side]!,
    );
  const [columns, rows] = [rays(a, 0, width), rays(b, 1, height)];
  // Whole cells are found by rounding down.
  const [left, top] = [a, b].map((side) => (eye[side]! - origin[side]!) / scale[side]! + 0.5) as [number, number]; // prettier-ignore
  const stamps = stampsOf(lattice, chunk, band);
  const words = new Uint16Array(WORDS * pixels.length);
  for (let i = 0, w = 0; i < pixels.length; i++, w += WORDS) {
    const pixel = pixels[i]!;
    const depth = depths[pixel]!;
    const row = (pixel / width) | 0;
    words[w + axis] = sign > 0 ? depth : FARTHEST - depth;
    words[w + a] = bounded(left + depth * columns[pixel - row * width]!);
    words[w + b] = bounded(top + depth * rows[row]!);
    words[w + 5] = stamps[depth >> SIZE_SHIFT]!;
  }
  return words;
}

function bounded(cell: number): number {
  return cell < 0 ? 0 : cell > FARTHEST ? FARTHEST : cell;
}

/** Stamps (chunk and size) of a band's points, for depths `1 << SIZE_SHIFT` apart. */
function stampsOf({ pitch, unit }: Lattice, chunk: number, { down, across }: Band): Uint16Array {
  const apart = SLANT * Math.sqrt(pitch[0] * pitch[1] * down * across) * unit;
  const row = (chunk % MAX_CHUNKS) * SIZE_CODES;
  return Uint16Array.from(
    { length: (FARTHEST >> SIZE_SHIFT) + 1 },
    (_, i) => row + sizeCode((i + 0.5) * apart * (1 << SIZE_SHIFT)),
  );
}
