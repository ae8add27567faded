/** Pixels and their depths → points on a grid of 16 bits, as chunks of points have them. */
import { bounded, FARTHEST, product, type Grid, type Matrix } from '../chunk/grid';
import { sizeCode, MAX_CHUNKS, SIZE_CODES, WORDS, type DepthImage } from '../chunk/segment';
import type { Lattice } from '../../protocol/messages';
import type { Band } from './lattice';

type View = Pick<DepthImage, 'lattice' | 'mount'>;

/** `1 << SIZE_SHIFT` depths share a size. */
const SIZE_SHIFT = 5;
/** Surfaces are seen askew, most of them by so much: their points lie farther apart. */
export const SLANT = 1.15;

/** The grid of points in a box; along the axis of a camera without a mount, its depths. */
export function gridOf({ lattice, mount }: View, box: Grid): Grid {
  const { axis, sign, eye, unit } = lattice;
  if (mount) return box;
  const start = eye[axis]! - (sign > 0 ? 0 : FARTHEST * unit);
  return {
    origin: box.origin.with(axis, start),
    scale: box.scale.with(axis, unit),
  } as unknown as Grid;
}

/** The axes that columns and rows go along. */
export function sidesOf({ axis }: Lattice): [number, number] {
  return axis === 0 ? [1, 2] : axis === 1 ? [0, 2] : [0, 1];
}

/** `T_local_pixel` of a camera: local metres of 1, a depth, and the depth times column and row. */
export function raysOf({ lattice, mount }: View): Matrix {
  const { axis, sign, eye, unit, tangent, pitch } = lattice;
  const [a, b] = sidesOf(lattice);
  const rays = new Array<number>(16).fill(0);
  eye.forEach((metres, side) => (rays[4 * side] = metres));
  rays[12] = 1;
  rays[4 * axis + 1] = sign * unit;
  rays[4 * a + 1] = unit * tangent[0];
  rays[4 * a + 2] = unit * pitch[0];
  rays[4 * b + 1] = unit * tangent[1];
  rays[4 * b + 3] = unit * pitch[1];
  return mount ? product(mount, rays) : rays;
}

/**
 * Return the words of a chunk's points (see `Piece`), without colours.  `pixels` are row-major, the
 * depths are of the whole image.
 */
export function unproject(
  image: View & Pick<DepthImage, 'depths'>,
  { origin, scale }: Grid,
  chunk: number,
  band: Band,
  pixels: Uint32Array,
): Uint16Array<ArrayBuffer> {
  const { lattice, depths } = image;
  const { width, height } = lattice;
  const rays = raysOf(image);
  // Whole cells are found by rounding down.
  const [x, y, z] = origin.map((start, k) => (rays[4 * k]! - start) / scale[k]! + 0.5) as [number, number, number]; // prettier-ignore
  const cells = (of: (k: number, place: number) => number, count: number): Float64Array =>
    Float64Array.from({ length: 3 * count }, (_, i) => of(i % 3, (i / 3) | 0) / scale[i % 3]!);
  const columns = cells((k, column) => rays[4 * k + 1]! + rays[4 * k + 2]! * column, width);
  const rows = cells((k, row) => rays[4 * k + 3]! * row, height);
  const stamps = stampsOf(lattice, chunk, band);
  const words = new Uint16Array(WORDS * pixels.length);
  for (let i = 0, w = 0; i < pixels.length; i++, w += WORDS) {
    const pixel = pixels[i]!;
    const depth = depths[pixel]!;
    const row = (pixel / width) | 0;
    const [c, r] = [3 * (pixel - row * width), 3 * row];
    words[w] = bounded(x + depth * (columns[c]! + rows[r]!));
    words[w + 1] = bounded(y + depth * (columns[c + 1]! + rows[r + 1]!));
    words[w + 2] = bounded(z + depth * (columns[c + 2]! + rows[r + 2]!));
    words[w + 5] = stamps[depth >> SIZE_SHIFT]!;
  }
  return words;
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
