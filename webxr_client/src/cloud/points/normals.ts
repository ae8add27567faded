/** Directions of surfaces as colours: of each point's neighbourhood in a grid as fine as the points. */
import type { Matrix4 } from 'three';
import { SIZE_CODES, spacingOf } from '../../net/chunk/segment';
import type { Piece } from './piece';

/** Cells are at least so many spacings wide; a neighbourhood is three cells wide. */
const CELL = 2;
/** A plane goes through at least so many points. */
const LEAST = 4;
/** Sums of a cell: points, x y z, and xx xy xz yy yz zz. */
const SUMS = 10;
/** Colour of points without a surface among their neighbours. */
const NONE = 128;

/** Size code of a point → power of two of its cell's width, metres. */
const LEVELS = Int8Array.from({ length: SIZE_CODES }, (_, code) =>
  Math.ceil(Math.log2(CELL * spacingOf(code))),
);

/**
 * Colours (3 bytes a point) of the points of `pieces`: red, green and blue are the normal's parts
 * along the axes of the room, −1..1 as 0..255.  Normals point to the sensor at `eye`, local metres.
 *
 * Spacing differs between near and far, and so do cells: each point counts in a cell of its own
 * size and in the one twice as wide, where coarser neighbours look for it.
 */
export function normalColours(
  pieces: readonly Piece[],
  room: Matrix4,
  eye: ArrayLike<number> = [0, 0, 0],
): Uint8Array {
  const { xyz, levels, points } = gather(pieces);
  const grid = new Grid(2 * points);
  const own = new Int32Array(points);
  const wide = new Int32Array(points);
  for (let i = 0; i < points; i++) {
    const level = levels[i]!;
    own[i] = cellAt(grid, xyz, i, level);
    wide[i] = cellAt(grid, xyz, i, level + 1);
  }
  const sums = new Float64Array(SUMS * grid.count);
  for (let i = 0; i < points; i++) {
    addPoint(sums, own[i]!, xyz, i);
    addPoint(sums, wide[i]!, xyz, i);
  }
  const normals = new Float64Array(3 * grid.count).fill(NaN);
  const colours = new Uint8Array(3 * points);
  const e = room.elements;
  for (let i = 0; i < points; i++) {
    const at = 3 * own[i]!;
    if (Number.isNaN(normals[at])) normals.set(normalOf(grid, sums, own[i]!), at);
    let x = normals[at]!;
    let y = normals[at + 1]!;
    let z = normals[at + 2]!;
    const [dx, dy, dz] = [xyz[3 * i]! - eye[0]!, xyz[3 * i + 1]! - eye[1]!, xyz[3 * i + 2]! - eye[2]!]; // prettier-ignore
    if (x * dx + y * dy + z * dz > 0) [x, y, z] = [-x, -y, -z];
    for (let k = 0; k < 3; k++) {
      const part = e[k]! * x + e[4 + k]! * y + e[8 + k]! * z;
      colours[3 * i + k] = Math.max(0, Math.min(255, Math.round(NONE + 127 * part)));
    }
  }
  return colours;
}

interface Gathered {
  /** Local coordinates, metres. */
  readonly xyz: Float64Array;
  readonly levels: Int8Array;
  readonly points: number;
}

function gather(pieces: readonly Piece[]): Gathered {
  const points = pieces.reduce((sum, { count }) => sum + count, 0);
  const xyz = new Float64Array(3 * points);
  const levels = new Int8Array(points);
  let at = 0;
  for (const { words, origin, scale, count } of pieces) {
    for (let i = 0; i < count; i++, at++) {
      for (let k = 0; k < 3; k++) xyz[3 * at + k] = origin[k]! + words[6 * i + k]! * scale[k]!;
      levels[at] = LEVELS[words[6 * i + 5]! % SIZE_CODES]!;
    }
  }
  return { xyz, levels, points };
}

function cellAt(grid: Grid, xyz: Float64Array, point: number, level: number): number {
  const finer = 2 ** -level;
  return grid.put(
    Math.floor(xyz[3 * point]! * finer),
    Math.floor(xyz[3 * point + 1]! * finer),
    Math.floor(xyz[3 * point + 2]! * finer),
    level,
  );
}

function addPoint(sums: Float64Array, cell: number, xyz: Float64Array, point: number): void {
  const x = xyz[3 * point]!;
  const y = xyz[3 * point + 1]!;
  const z = xyz[3 * point + 2]!;
  const at = SUMS * cell;
  sums[at]! += 1;
  sums[at + 1]! += x;
  sums[at + 2]! += y;
  sums[at + 3]! += z;
  sums[at + 4]! += x * x;
  sums[at + 5]! += x * y;
  sums[at + 6]! += x * z;
  sums[at + 7]! += y * y;
  sums[at + 8]! += y * z;
  sums[at + 9]! += z * z;
}

const around = new Float64Array(SUMS);

/** The normal of a cell's surface, from the points of all cells round it; 0, 0, 0: it has none. */
function normalOf(grid: Grid, sums: Float64Array, cell: number): readonly number[] {
  around.fill(0);
  const [x, y, z, level] = grid.cell(cell);
  for (let step = 0; step < 27; step++) {
    const [i, j, k] = [(step % 3) - 1, (Math.floor(step / 3) % 3) - 1, Math.floor(step / 9) - 1];
    const other = grid.find(x + i, y + j, z + k, level);
    if (other < 0) continue;
    for (let n = 0; n < SUMS; n++) around[n]! += sums[SUMS * other + n]!;
  }
  const [n, sx, sy, sz, xx, xy, xz, yy, yz, zz] = around as unknown as Ten;
  if (n < LEAST) return FLAT;
  return thinnest(
    xx / n - (sx / n) ** 2, xy / n - (sx * sy) / n ** 2, xz / n - (sx * sz) / n ** 2,
    yy / n - (sy / n) ** 2, yz / n - (sy * sz) / n ** 2, zz / n - (sz / n) ** 2,
  ); // prettier-ignore
}

type Ten = [number, number, number, number, number, number, number, number, number, number];
const FLAT = [0, 0, 0] as const;

/** The eigenvector of the least eigenvalue of a symmetric matrix; 0, 0, 0 where two are least. */
function thinnest(
  a: number,
  b: number,
  c: number,
  d: number,
  e: number,
  f: number,
): readonly number[] {
  const least = leastEigenvalue(a, b, c, d, e, f);
  const rows = [[a - least, b, c], [b, d - least, e], [c, e, f - least]] as const; // prettier-ignore
  let best: readonly number[] = FLAT;
  let longest = 0;
  // All rows are at right angles to it: the product of the two that differ most is the surest.
  for (const [p, q] of [[0, 1], [0, 2], [1, 2]] as const) {
    const cross = product(rows[p], rows[q]);
    const length = Math.hypot(...cross);
    if (length > longest) [longest, best] = [length, cross.map((part) => part / length)];
  } // prettier-ignore
  const size = a + d + f;
  return longest > 1e-6 * size * size ? best : FLAT;
}

type Three = readonly [number, number, number];

function product([a, b, c]: Three, [d, e, f]: Three): number[] {
  return [b * f - c * e, c * d - a * f, a * e - b * d];
}

/** By the cosine of a third of an angle (Smith 1961). */
function leastEigenvalue(a: number, b: number, c: number, d: number, e: number, f: number): number {
  const mean = (a + d + f) / 3;
  const [p, q, r] = [a - mean, d - mean, f - mean];
  const spread = Math.sqrt((p * p + q * q + r * r + 2 * (b * b + c * c + e * e)) / 6);
  if (spread === 0) return mean;
  const det = p * (q * r - e * e) - b * (b * r - e * c) + c * (b * e - q * c);
  const angle = Math.acos(Math.max(-1, Math.min(1, det / (2 * spread ** 3)))) / 3;
  return mean + 2 * spread * Math.cos(angle + (2 * Math.PI) / 3);
}

/** Cells by their place and level, numbered as they come. */
class Grid {
  count = 0;
  /** x, y, z, level of each cell. */
  private readonly cells: Int32Array;
  /** Number of a cell + 1; 0: free. */
  private readonly table: Int32Array;

  constructor(most: number) {
    this.cells = new Int32Array(4 * most);
    this.table = new Int32Array(2 ** Math.ceil(Math.log2(2 * most + 2)));
  }

  cell(number: number): readonly [number, number, number, number] {
    const { cells } = this;
    const at = 4 * number;
    return [cells[at]!, cells[at + 1]!, cells[at + 2]!, cells[at + 3]!];
  }

  /** Number of a cell, −1 where it has no points. */
  find(x: number, y: number, z: number, level: number): number {
    return this.table[this.seat(x, y, z, level)]! - 1;
  }

  /** Number of a cell, which is made where there is none. */
  put(x: number, y: number, z: number, level: number): number {
    const seat = this.seat(x, y, z, level);
    const found = this.table[seat]! - 1;
    if (found >= 0) return found;
    const at = 4 * this.count;
    this.cells[at] = x;
    this.cells[at + 1] = y;
    this.cells[at + 2] = z;
    this.cells[at + 3] = level;
    this.table[seat] = ++this.count;
    return this.count - 1;
  }

  /** Place in the table of a cell, or for it. */
  private seat(x: number, y: number, z: number, level: number): number {
    const { cells, table } = this;
    const last = table.length - 1;
    let hash = Math.imul(x, 73856093) ^ Math.imul(y, 19349663) ^ Math.imul(z, 83492791);
    hash = Math.imul(hash ^ Math.imul(level, 668265263), 0x9e3779b1);
    let seat = (hash ^ (hash >>> 15)) & last;
    for (;;) {
      const held = table[seat]! - 1;
      if (held < 0) return seat;
      const at = 4 * held;
      if (cells[at] === x && cells[at + 1] === y && cells[at + 2] === z && cells[at + 3] === level)
        return seat;
      seat = (seat + 1) & last;
    }
  }
}
