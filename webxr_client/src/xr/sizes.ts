/** Text in the room: metres of its em, and the farthest that it is usually read from, metres. */
export interface TextSize {
  readonly em: number;
  readonly away: number;
}

export const SIZES = {
  /** On the other hand, the arm stretched out. */
  palette: { em: 0.0132, away: 0.7 },
  /** Low before one, its far corners. */
  timeline: { em: 0.02, away: 1.1 },
  /** Beside a controller. */
  tips: { em: 0.012, away: 0.65 },
  /** Before the eyes. */
  message: { em: 0.024, away: 1.05 },
} as const satisfies Record<string, TextSize>;
