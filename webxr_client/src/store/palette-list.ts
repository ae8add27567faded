/** Labels as the palette lists them: found by the search, by category, numbered, one being renamed. */
import { computed, signal } from '@preact/signals';
import type { Label } from '../protocol/messages';
import { hasPoints } from './cells';
import { state } from './state';

/** Search words; the palette shows labels with all of them. */
export const search = signal('');
/** Whether the labels are open in a small window, where they lie over the picture. */
export const listOpen = signal(false);
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

/** Order of the palette: labels that are searched for, by category, in the order of the server. */
interface LabelGroup {
  /** The category that all have; null: the list is not grouped. */
  readonly category: string | null;
  readonly labels: readonly Label[];
}

/** Return the labels with each word of a search in their name or category, in any case. */
export function matching(palette: readonly Label[], search: string): readonly Label[] {
  const words = search.toLowerCase().split(/\s+/).filter(Boolean);
  if (words.length === 0) return palette;
  return palette.filter(({ name, category }) => {
    const text = `${name} ${category}`.toLowerCase();
    return words.every((word) => text.includes(word));
  });
}

/** Whether headings help: several categories, and fewer than labels. */
export function worthGrouping(palette: readonly Label[]): boolean {
  const categories = new Set(palette.map(({ category }) => category)).size;
  return categories > 1 && categories <= palette.length / 2;
}

/** The labels by category, in the order in which the categories come first. */
export function inGroups(palette: readonly Label[], grouped: boolean): readonly LabelGroup[] {
  if (!grouped) return [{ category: null, labels: palette }];
  const groups = new Map<string, Label[]>();
  for (const label of palette) {
    const group = groups.get(label.category);
    if (group) group.push(label);
    else groups.set(label.category, [label]);
  }
  return [...groups].map(([category, labels]) => ({ category, labels }));
}

/** Ids in the order after `moved` was put before `before` (null: behind all). */
export function reordered(
  ids: readonly number[],
  moved: number,
  before: number | null,
): readonly number[] {
  if (moved === before) return ids;
  const rest = ids.filter((id) => id !== moved);
  const at = before === null ? rest.length : rest.indexOf(before);
  return [...rest.slice(0, at), moved, ...rest.slice(at)];
}

/** The label with an open menu. */
export const menuOf = signal<number | null>(null);

/** The label that is being renamed. */
export const renaming = signal<number | null>(null);

/** Labels with points in a frame, in the palette's order; locked ones cannot be tracked. */
export function trackableLabels(frame: number): number[] {
  const { rows } = state.timeline.value;
  const present = state.palette.value.filter(
    ({ id, locked }) => !locked && hasPoints(rows.get(id), frame),
  );
  return present.map(({ id }) => id);
}
