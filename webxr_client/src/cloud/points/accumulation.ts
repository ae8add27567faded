/** Frames laid over the one on screen: the wanted number, and the loaded frames. */
import { computed, signal, type ReadonlySignal } from '@preact/signals';
import { layersOf, type Layer, type PlacedFrame } from './layer';

export interface Accumulation {
  readonly on: boolean;
  /** Frames before and after the one on screen. */
  readonly before: number;
  readonly after: number;
}

/** Frames on each side that the server takes in one stroke. */
export const MOST_AROUND = 500;

export const accumulation = signal<Accumulation>({ on: false, before: 5, after: 5 });

/** Frames over the one on screen now, the nearest first; none during playback. */
export const placedFrames = signal<readonly PlacedFrame[]>([]);

/** Frames that are wanted but not shown: too many points for one picture. */
export const leftOut = signal(0);

export const layers: ReadonlySignal<readonly Layer[]> = computed(() =>
  placedFrames.value.flatMap(layersOf),
);

/** Numbers of the frames that a stroke paints beside the one on screen. */
export function framesAround(): number[] {
  return placedFrames.peek().map(({ frame }) => frame.index);
}
