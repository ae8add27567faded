/** Similarity of sets of points, and of the places of two rays. */
import type { Sample } from '../protocol/messages';

/** Least share of common points in the union of two sets of one object. */
const LEAST = 0.5;

/** Points in both of two ascending lists. */
function common(one: Uint32Array, other: Uint32Array): number {
  let [i, j, both] = [0, 0, 0];
  while (i < one.length && j < other.length) {
    const difference = one[i]! - other[j]!;
    if (difference === 0) both += 1;
    if (difference <= 0) i += 1;
    if (difference >= 0) j += 1;
  }
  return both;
}

/** The set that has most in common with `like`; null when each is another object. */
export function mostLike(
  sets: readonly { readonly indices: Uint32Array }[],
  like: Uint32Array,
): number | null {
  let [best, most]: [number | null, number] = [null, LEAST];
  sets.forEach(({ indices }, level) => {
    const both = common(indices, like);
    const share = both / Math.max(1, indices.length + like.length - both);
    if (share >= most) [best, most] = [level, share];
  });
  return best;
}

/** Distance between two rays that are one place, as a part of the unit direction. */
const SAME_PLACE = 0.004;

/** Whether two rays point at one place. */
export function samePlace(one: Sample | undefined, other: Sample): boolean {
  if (!one) return false;
  const a = one.direction ?? [0, 0, -1];
  const b = other.direction ?? [0, 0, -1];
  let turn = 0;
  let move = 0;
  for (let k = 0; k < 3; k++) {
    turn += (a[k]! - b[k]!) ** 2;
    move += (one.origin[k]! - other.origin[k]!) ** 2;
  }
  return turn < SAME_PLACE ** 2 && move < SAME_PLACE ** 2;
}
