/** Haptics of the hand: points that change, frames passing, work that ends, a lock. */
import type { StrokeResult } from '../protocol/messages';

/** Strength of a pulse for so many newly changed points: felt from one, full at a thousand. */
export function strengthOf(points: number): number {
  return points <= 0 ? 0 : Math.min(1, 0.2 + 0.8 * (Math.log10(points) / 3));
}

export interface Pulse {
  readonly strength: number;
  readonly milliseconds: number;
}

/** A short dry tick, unlike the hum of painting. */
export const FRAME_TICK: Pulse = { strength: 0.35, milliseconds: 6 };
export const BUTTON_TICK: Pulse = { strength: 0.2, milliseconds: 8 };
/** Another level of an object is shown. */
export const LEVEL_TICK: Pulse = { strength: 0.5, milliseconds: 15 };
/** Tracking ended, or a label is locked. */
export const BUMP: Pulse = { strength: 1, milliseconds: 120 };
export const PAINT_MS = 25;

/**
 * Differences of the server's running counts, stroke by stroke.  What a stroke only touches, since
 * it has the label already, is not felt.
 */
export class ChangeCounter {
  private readonly seen = new Map<string, number>();

  /** Points that this answer says are changed and no earlier one said. */
  take(result: Pick<StrokeResult, 'id' | 'changed' | 'final'>): number {
    const before = this.seen.get(result.id) ?? 0;
    if (result.final) this.seen.delete(result.id);
    else this.seen.set(result.id, result.changed);
    return Math.max(0, result.changed - before);
  }
}
