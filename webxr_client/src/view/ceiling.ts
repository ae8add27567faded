/** The ceiling of a room, which hides the room from above. */
import type { Matrix4 } from 'three';
import type { CloudFrame } from '../cloud/points/frame';
import { samplePoints } from '../cloud/points/samples';
import { quantile } from './framing';

/** Number of sampled points, and the least number for a room. */
const [SAMPLES, LEAST] = [6000, 300];
/** Parts of the points between which a room lies in each direction: others are strays. */
const [LOW, HIGH] = [0.02, 0.98];
/** Greatest width of a room and least height of its ceiling, metres. */
const [WIDEST, LEAST_HEADROOM] = [30, 1.8];
/** A ceiling is level, and a floor flat, within so many metres. */
const [LEVEL, FLAT] = [0.2, 0.4];
/** Part of the height above which most points of a cell belong to a ceiling, unlike a tree's crown. */
const UPPER = 0.75;
/** Metres below a ceiling that a plan leaves out, too. */
const BELOW = 0.15;
/** Cells along each side of the plan. */
const CELLS = 8;
/** Of the cells away from the walls: part that a ceiling fills, and part that may rise above it. */
const [FILLED, ABOVE] = [0.2, 0.05];
/** Part of the cells under a ceiling where the floor is seen: under a roof it is not. */
const FLOORED = 0.5;
/** A wall has points in each of so many bands of height, in so many cells along a side, on so many sides. */
const [BANDS, WALL, SIDES] = [4, 3, 3];

/** Height below which a plan shows the room and not its ceiling, metres; null without a ceiling. */
export function underCeiling(frame: CloudFrame, room: Matrix4): number | null {
  const points = samplePoints(frame, room, SAMPLES);
  if (points.length < LEAST) return null;
  const part = (axis: 'x' | 'y' | 'z', share: number): number =>
    quantile(points.map((point) => point[axis]), share); // prettier-ignore
  const [left, near, floor] = [part('x', LOW), part('z', LOW), part('y', LOW / 2)];
  const [wide, deep] = [part('x', HIGH) - left, part('z', HIGH) - near];
  if (Math.max(wide, deep) > WIDEST || Math.min(wide, deep) === 0) return null;
  const cells: number[][] = Array.from({ length: CELLS ** 2 }, () => []);
  for (const { x, y, z } of points) {
    const [column, row] = [cellOf((x - left) / wide), cellOf((z - near) / deep)];
    cells[CELLS * row + column]!.push(y - floor);
  }
  const height = closedAt(cells.filter((_, i) => isInner(i)));
  if (height === null || sidesWithWall(cells, height) < SIDES) return null;
  return floor + height - BELOW;
}

function cellOf(share: number): number {
  return Math.min(CELLS - 1, Math.max(0, Math.floor(CELLS * share)));
}

/** Whether a cell is away from the sides of the plan. */
function isInner(cell: number): boolean {
  const [row, column] = [Math.floor(cell / CELLS), cell % CELLS];
  return Math.min(row, column) > 0 && Math.max(row, column) < CELLS - 1;
}

/**
 * Height at which a level surface closes cells from above, with a floor below it; null without one.
 * `cells`: heights of the points in each, metres above the floor.
 */
function closedAt(cells: readonly (readonly number[])[]): number | null {
  const tops = cells.map((heights) => Math.max(0, ...heights));
  const height = quantile(tops, 1 - ABOVE);
  const closed = cells.filter((heights) => {
    const upper = heights.filter((y) => y > UPPER * height);
    return 2 * upper.filter((y) => Math.abs(y - height) < LEVEL).length > upper.length;
  });
  const floored = closed.filter((heights) => Math.min(...heights) < FLAT);
  const found =
    height > LEAST_HEADROOM &&
    closed.length >= FILLED * cells.length &&
    floored.length >= FLOORED * closed.length;
  return found ? height : null;
}

/** Number of the plan's sides along which walls stand from the floor to the ceiling. */
function sidesWithWall(cells: readonly (readonly number[])[], height: number): number {
  const isWall = (cell: number): boolean => {
    const bands = cells[cell]!.map((y) => Math.floor((BANDS * y) / height));
    return Array.from({ length: BANDS }, (_, band) => bands.includes(band)).every(Boolean);
  };
  const side = (first: number, step: number): number =>
    Array.from({ length: CELLS }, (_, i) => first + i * step).filter(isWall).length;
  const last = CELLS - 1;
  const walls = [side(0, 1), side(CELLS * last, 1), side(0, CELLS), side(last, CELLS)];
  return walls.filter((length) => length >= WALL).length;
}
