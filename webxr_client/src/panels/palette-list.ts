/** Labels that the palette lists now, and their numbers. */
import { computed, signal } from '@preact/signals';
import { state } from '../state';
import { inGroups, matching, worthGrouping } from './palette-order';

/** The palette shows labels with these words. */
export const search = signal('');
/** Whether the person wants headings by category. */
export const wantsGroups = signal(true);

export const canGroup = computed(() => worthGrouping(state.palette.value));
const grouped = computed(() => wantsGroups.value && canGroup.value);

/** All labels by category, as numbers count them. */
const allGroups = computed(() => inGroups(state.palette.value, grouped.value));

/** Every label as the palette lists it, from the top. */
export const listed = computed(() => allGroups.value.flatMap(({ labels }) => labels));

/** The groups with labels that the search finds. */
export const shownGroups = computed(() =>
  allGroups.value
    .map((group) => ({ ...group, labels: matching(group.labels, search.value) }))
    .filter(({ labels }) => labels.length > 0),
);

/** Key of the n-th label, from 1: 1 to 9, then Shift 1 to 9. */
export function keyOf(n: number): string | null {
  if (n <= 9) return String(n);
  return n <= 18 ? `⇧${n - 9}` : null;
}
