/**
 * Text in the room.  The height of capital letters is at least a degree, so that an em, the unit of
 * font sizes, is at least 1.4°.
 */

/** Height of a capital letter in ems: Inter's own metrics, 1490 of 2048 units. */
export const CAPITAL = 1490 / 2048;
/** Least height of a capital letter, as seen. */
export const LEAST_DEGREES = 1;

export interface TextSize {
  /** Metres of the em. */
  readonly em: number;
  /** Maximum reading distance, metres; panels that follow the hands grow beyond it. */
  readonly distance: number;
}

/** Height of a capital letter at a distance, degrees. */
export function degrees({ em, distance }: TextSize): number {
  return (Math.atan2(CAPITAL * em, distance) * 180) / Math.PI;
}

export const SIZES = {
  /** On the other hand, the arm bent; so near that its corners, farther away, are a degree as well. */
  palette: { em: 0.0132, distance: 0.46 },
  /** Low before one, its far corners. */
  timeline: { em: 0.0268, distance: 1.09 },
  /** A question before the eyes, its far corners. */
  question: { em: 0.0217, distance: 0.9 },
  /** To the side, as long as a headset is checked; its far corners. */
  check: { em: 0.0224, distance: 0.93 },
  /** Beside a controller. */
  tips: { em: 0.0122, distance: 0.5 },
  /** Before the eyes. */
  message: { em: 0.025, distance: 1.03 },
  /** Above another person's head. */
  name: { em: 0.05, distance: 2 },
} as const satisfies Record<string, TextSize>;
