/** The stretch of frames chosen on the timeline, for tracking and export. */
import { signal } from '@preact/signals';

export interface FrameRange {
  /** Frame at which the user began; tracking starts there, forward or backward. */
  readonly from: number;
  readonly to: number;
}

export const frameRange = signal<FrameRange | null>(null);

/** Lowest and highest frame of a range. */
export function ordered(range: FrameRange): readonly [number, number] {
  return range.from <= range.to ? [range.from, range.to] : [range.to, range.from];
}
