/** The grid of 16 bits that points are rounded to, and what a lattice's pixels are on it. */
import { sizeCode, MAX_CHUNKS, SIZE_CODES } from '../chunk/segment';
import type { Lattice } from '../../protocol/messages';
import type { Band } from './lattice';

type Vector = readonly [number, number, number];

/** The depth's own along the camera's axis, across it the recording's box in 65,535 cells. */
export interface Grid {
  readonly origin: Vector;
  readonly scale: Vector;
}

export const FARTHEST = 65535;
/** `1 << SIZE_SHIFT` depths share a size. */
const SIZE_SHIFT = 5;
/** Surfaces are seen askew, most of them by so much: their points lie farther apart. */
const SLANT = 1.15;

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

/** Numbers of a vector in the kernel: three coordinates and a spare one. */
export const LANES = 4;

/** Points on the grid: `origin + depth * (columns + rows)`, vectors of the pixel's column and row. */
export interface Rays {
  readonly origin: Float32Array;
  readonly columns: Float32Array;
  readonly rows: Float32Array;
}

export function raysOf(lattice: Lattice, grid: Grid): Rays {
  const { width, height, axis, sign, eye, unit, tangent, pitch } = lattice;
  const sides = [0, 1, 2].filter((side) => side !== axis);
  const origin = new Float32Array(LANES);
  const [columns, rows] = [width, height].map((count, i) => {
    const side = sides[i]!;
    const cell = grid.scale[side]!;
    const rays = new Float32Array(LANES * count);
    for (let pixel = 0; pixel < count; pixel++) {
      rays[LANES * pixel + side] = (unit * (tangent[i]! + pitch[i]! * pixel)) / cell;
    }
    // The kernel rounds down.
    origin[side] = (eye[side]! - grid.origin[side]!) / cell + 0.5;
    return rays;
  }) as [Float32Array, Float32Array];
  for (let pixel = 0; pixel < width; pixel++) columns[LANES * pixel + axis] = sign;
  origin[axis] = sign > 0 ? 0 : FARTHEST;
  return { origin, columns, rows };
}

/** Stamps of a band, for depths `1 << SIZE_SHIFT` apart. */
export const STAMPS = (FARTHEST >> SIZE_SHIFT) + 1;

/** Stamps (chunk and size) of points, `STAMPS` by depth for each band. */
export function stampsOf({ pitch, unit }: Lattice, bands: readonly Band[]): Uint16Array {
  const stamps = new Uint16Array(STAMPS * bands.length);
  bands.forEach(({ down, across }, chunk) => {
    const apart = SLANT * Math.sqrt(pitch[0] * pitch[1] * down * across) * unit;
    const row = (chunk % MAX_CHUNKS) * SIZE_CODES;
    for (let i = 0; i < STAMPS; i++) {
      stamps[chunk * STAMPS + i] = row + sizeCode((i + 0.5) * apart * (1 << SIZE_SHIFT));
    }
  });
  return stamps;
}
