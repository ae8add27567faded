/** Grids of 16 bits that points lie on, and the way from a sensor's grid to one of the recording. */
import type { SequenceInfo } from '../../protocol/messages';
import { WORDS } from './segment';

type Vector = readonly [number, number, number];
/** 4x4, row-major. */
export type Matrix = readonly number[];

/** Greatest whole number of cells, and of a depth in units. */
export const FARTHEST = 65535;

/** Position = origin + cell × scale, along each side. */
export interface Grid {
  readonly origin: Vector;
  readonly scale: Vector;
}

/** A box in 65,535 cells along each side. */
export function boxGrid(lo: Vector, hi: Vector): Grid {
  const scale = lo.map((low, side) => Math.max((hi[side]! - low) / FARTHEST, 1e-9));
  return { origin: lo, scale: scale as unknown as Vector };
}

export function bounded(cell: number): number {
  return cell < 0 ? 0 : cell > FARTHEST ? FARTHEST : cell;
}

/** `T_local_sensor` in a frame, row-major; null: chunks and lattice are in local coordinates. */
export function mountOf({ sensors }: SequenceInfo, sensor: number, frame: number): Matrix | null {
  const found = sensors[sensor];
  if (!found) return null;
  const { T_frame_sensor: mounts, correction } = found;
  return product(mounts[mounts.length > 1 ? frame : 0]!, correction);
}

/** Position of a sensor by its mount, local metres. */
export function eyeOf(mount: Matrix | null): Vector {
  return mount ? [mount[3]!, mount[7]!, mount[11]!] : [0, 0, 0];
}

export function product(a: Matrix, b: Matrix): number[] {
  return Array.from({ length: 16 }, (_, at) =>
    [0, 1, 2, 3].reduce((sum, k) => sum + a[(at & 12) + k]! * b[4 * k + (at & 3)]!, 0),
  );
}

function scaling(scale: readonly number[], shift: readonly number[]): number[] {
  const [x, y, z] = scale as Vector;
  return [x, 0, 0, shift[0]!, 0, y, 0, shift[1]!, 0, 0, z, shift[2]!, 0, 0, 0, 1];
}

/** Move points (see `Piece.words`) by a transform from one grid to another. */
export function move(words: Uint16Array, from: Grid, T: Matrix, to: Grid): void {
  const inverse = to.scale.map((scale) => 1 / scale);
  const shift = to.origin.map((origin, k) => -origin * inverse[k]!);
  const cells = product(product(scaling(inverse, shift), T), scaling(from.scale, from.origin));
  for (let i = 0; i < words.length; i += WORDS) {
    const [x, y, z] = [words[i]!, words[i + 1]!, words[i + 2]!];
    for (let k = 0; k < 3; k++) {
      const row = 4 * k;
      // Whole cells are found by rounding down.
      words[i + k] = bounded(cells[row]! * x + cells[row + 1]! * y + cells[row + 2]! * z + cells[row + 3]! + 0.5); // prettier-ignore
    }
  }
}
