/** Label colours of this person: the usual ones, or a set for colour-blind people. */
import { computed, signal, type ReadonlySignal } from '@preact/signals';
import { LABEL_COLORS, SAFE_COLORS } from '../common/colors';
import { keep, kept } from './kept';

const KEY = 'pointbrush.safe-colours';

export const safeColours = signal(kept(KEY) === 'yes');
export const labelColours: ReadonlySignal<readonly string[]> = computed(() =>
  safeColours.value ? SAFE_COLORS : LABEL_COLORS,
);

export function chooseSafeColours(on: boolean): void {
  safeColours.value = on;
  keep(KEY, on ? 'yes' : 'no');
}
