/** The interlaced levels of a depth camera's pixels, as the server cuts them (`docs/depth-format.md`). */
import type { Lattice } from '../../protocol/messages';

/** Rows of a strip: a level's points are numbered strip by strip, column by column within one. */
export const STRIP = 16;
const LEVEL0_PIXELS = 4096;
const CHUNK_PIXELS = 65536;

type Pixels = Uint32Array<ArrayBuffer>;

/** The pixels of a chunk. */
export interface Band {
  readonly level: number;
  /** Rows from `row` to before `stop`. */
  readonly row: number;
  readonly stop: number;
  readonly column: number;
  /** Steps from row to row, and column to column. */
  readonly down: number;
  readonly across: number;
  /** Distance to the neighbours that are known, 0 in level 0; above and below when `vertical`. */
  readonly half: number;
  readonly vertical: boolean;
  /** Of the lattice that is complete behind this level, and of the picture with its colours. */
  readonly step: number;
  readonly pictureStep: number;
}

type Size = Pick<Lattice, 'width' | 'height'>;

/** Distance between the pixels of level 0. */
export function firstStep({ width, height }: Size): number {
  let step = 1;
  while (Math.ceil(width / step) * Math.ceil(height / step) > LEVEL0_PIXELS) step *= 2;
  return step;
}

/** The chunks that a frame has, in their order. */
export function bandsOf(size: Size): Band[] {
  let step = firstStep(size);
  const bands = cut(size, { level: 0, row: 0, column: 0, down: step, across: step, half: 0, step });
  for (let level = 1; step > 1; level += 2) {
    const half = step / 2;
    const between = { half, step: half };
    bands.push(
      ...cut(size, { ...between, level, row: 0, column: half, down: step, across: step }),
      ...cut(size, {
        ...between,
        level: level + 1,
        row: half,
        column: 0,
        down: step,
        across: half,
      }),
    );
    step = half;
  }
  return bands;
}

type Level = Omit<Band, 'stop' | 'vertical' | 'pictureStep'>;

function cut({ width, height }: Size, level: Level): Band[] {
  const rows = Math.ceil((height - level.row) / level.down);
  const columns = Math.ceil((width - level.column) / level.across);
  if (rows <= 0 || columns <= 0) return [];
  const strips = Math.ceil(rows / STRIP);
  const parts = Math.ceil((rows * columns) / CHUNK_PIXELS);
  const rowOf = (part: number) =>
    level.row + Math.floor((strips * part) / parts) * STRIP * level.down;
  return Array.from({ length: parts }, (_, part) => ({
    ...level,
    row: rowOf(part),
    stop: Math.min(rowOf(part + 1), height),
    vertical: level.half > 0 && level.row > 0,
    pictureStep: pictureStep(level.step),
  }));
}

/** Number of pixels in a band, with or without a point. */
export function pixelsOf({ row, stop, column, down, across }: Band, width: number): number {
  return Math.ceil((stop - row) / down) * Math.ceil((width - column) / across);
}

/** The pixels of a band's `count` points, row-major, in their order: those that have a depth. */
export function pointsOf(band: Band, width: number, depths: Uint16Array, count: number): Pixels {
  const { row: first, stop, column, down, across } = band;
  const pixels = new Uint32Array(count);
  let i = 0;
  for (let strip = first; strip < stop; strip += STRIP * down) {
    const end = Math.min(strip + STRIP * down, stop) * width;
    for (let left = column; left < width; left += across) {
      for (let pixel = strip * width + left; pixel < end; pixel += down * width) {
        if (depths[pixel]! > 0) pixels[i++] = pixel;
      }
    }
  }
  return pixels;
}

/** Pictures have every pixel, every second, every eighth, and so on: the coarsest that will do. */
function pictureStep(step: number): number {
  let found = 1;
  for (let coarser = 2; coarser <= step; coarser *= 4) found = coarser;
  return found;
}
