/** Order of the palette: labels that are searched for, by category, in the order of the server. */
import type { Label } from '../protocol/messages';

export interface LabelGroup {
  /** The category that all have; null: the list is not grouped. */
  readonly category: string | null;
  readonly labels: readonly Label[];
}

/** Labels whose name or category has each word of a search, in any case. */
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
