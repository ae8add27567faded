/** Roles of inputs, to paint or to hold the palette, by present inputs and the preferred hand. */
import type { Side } from '../../store/xr-settings';

/** Properties by which input sources are told apart. */
export interface Present {
  /** Its place in the table of kinds: of one side the lowest comes first. */
  readonly rank: number;
  readonly side: Side | 'none';
  /** It comes to press and goes when it is let go. */
  readonly momentary: boolean;
  /** It stays between presses and is held somewhere: a palette can stand over it. */
  readonly holds: boolean;
  /** It can press; an input that is only tracked (a controller laid aside) cannot. */
  readonly primary: boolean;
}

export interface Roles<T extends Present> {
  /** Paints. */
  readonly brush: T | null;
  /** Goes and turns, takes hold of the room, presses the other buttons. */
  readonly other: T | null;
  /** Holds the palette. */
  readonly palette: T | null;
}

/**
 * The roles of the present inputs, in their order of arrival.  A single input paints, on either
 * side.  Transient inputs must be of the wished side, or of none, because a pinch of the other hand
 * grabs the room.
 */
export function rolesOf<T extends Present>(present: readonly T[], wished: Side): Roles<T> {
  const sideCost = ({ side }: T): number => (side === wished ? 0 : side === 'none' ? 1 : 2);
  const paints = (one: T): boolean => one.primary && !(one.momentary && sideCost(one) === 2);
  const brush = first(present.filter(paints), (one) => [sideCost(one), one.rank]);
  // Two sources of one side are one hand, which does not help itself.
  const rest = present.filter(
    (one) => one !== brush && (one.side === 'none' || one.side !== brush?.side),
  );
  const other = first(
    rest.filter((one) => one.primary),
    (one) => [-sideCost(one), one.rank],
  );
  const palette = first(
    rest.filter((one) => one.holds),
    (one) => [one.primary ? 0 : 1, -sideCost(one), one.rank],
  );
  return { brush, other, palette };
}

/** The one with the lowest key, the earliest of equals. */
function first<T>(all: readonly T[], keyOf: (one: T) => readonly number[]): T | null {
  let best: T | null = null;
  for (const one of all) if (best === null || less(keyOf(one), keyOf(best))) best = one;
  return best;
}

function less(a: readonly number[], b: readonly number[]): boolean {
  const at = a.findIndex((value, i) => value !== b[i]);
  return at >= 0 && a[at]! < b[at]!;
}
