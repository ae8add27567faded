/** Grips of a box for a hand in the room. */
import type { Shape, Side } from './shape';
import type { Triple } from '../store/boxes';

/** The sides that are held: three of a corner, one of a face; or the whole box. */
export type Grip = readonly [Side, Side, Side] | 'all';

/** Corners and faces are met within this part of the box's shortest edge, too. */
const PART = 0.22;

/** Corners and faces. */
export const HANDLES: readonly (readonly [Side, Side, Side])[] = [
  ...[0, 1, 2, 3, 4, 5, 6, 7].map(
    (bits) => [bits & 1 ? 1 : -1, bits & 2 ? 1 : -1, bits & 4 ? 1 : -1] as const,
  ),
  [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1],
]; // prettier-ignore

/**
 * Find the grip of a hand at a place (the box's coordinates): the nearest corner or middle of
 * a face within `reach` metres, else the box it is in; null beside it.
 */
export function gripOf({ size }: Shape, at: Triple, reach: number): Grip | null {
  const within = Math.max(reach, PART * Math.min(...size));
  let best: Grip | null = size.every((edge, k) => Math.abs(at[k]!) <= edge / 2 + reach)
    ? 'all'
    : null;
  let nearest = within;
  for (const sides of HANDLES) {
    const distance = Math.hypot(...sides.map((side, k) => (side * size[k]!) / 2 - at[k]!));
    if (distance >= nearest) continue;
    nearest = distance;
    best = sides;
  }
  return best;
}
