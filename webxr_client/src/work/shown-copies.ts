/** Labels of copies → ids of the palette's texture. */
import type { Label } from '../protocol/messages';
import type { Shows } from './copies';

/** Labels of one frame's points, in stored order, and their palette. */
export interface Copy {
  readonly labels: Uint16Array;
  readonly palette: readonly Label[];
}

/** Only the first has a label, only the second, another one, the same; as the server draws them. */
const DIFFERENCES = ['#409cff', '#ff9f1c', '#ff4081', '#969ca8'];
/** Points without a label in either, beside them. */
const REST = { dark: '#3a3e48', light: '#b4bac5' };
const OWN = DIFFERENCES.length + 1;

/** Read an array of `numpy.save` of two bytes a value. */
export function labelsOf(bytes: ArrayBuffer): Uint16Array<ArrayBuffer> {
  const head = new DataView(bytes).getUint16(8, true);
  return new Uint16Array(bytes, 10 + head);
}

/** True for a label that is the recording's, too: its colour there is shown. */
function isKnown({ id, name, category }: Label, own: readonly Label[]): boolean {
  return own.some((each) => each.id === id && each.name === name && each.category === category);
}

/** Labels of two copies that the recording does not have, the first's before the second's. */
function foreignLabels(first: readonly Label[], second: readonly Label[], own: readonly Label[]) {
  return [first, second].map((palette) => palette.filter((label) => !isKnown(label, own)));
}

/** Colours of the ids that `idsOf` gives from `base` on. */
export function coloursOf(
  first: readonly Label[],
  second: readonly Label[],
  own: readonly Label[],
  theme: keyof typeof REST,
): readonly string[] {
  const more = foreignLabels(first, second, own).flat();
  return [...DIFFERENCES, REST[theme], ...more.map(({ color }) => color)];
}

/** Ids that show a copy, or where two differ, in the palette of the recording, `own`. */
export function idsOf(
  first: Copy,
  second: Copy,
  own: readonly Label[],
  what: Shows,
  base: number,
): Uint16Array {
  if (what === 'difference') return differences(first, second, base);
  const at = what === 'second' ? 1 : 0;
  const shown = at === 0 ? first : second;
  const more = foreignLabels(first.palette, second.palette, own);
  const before = base + OWN + (at === 0 ? 0 : more[0]!.length);
  const to = new Map(more[at]!.map(({ id }, k) => [id, before + k]));
  return shown.labels.map((label) => to.get(label) ?? label);
}

/** The class by which labels of two people are the same. */
function classes(palette: readonly Label[]): ReadonlyMap<number, string> {
  return new Map(palette.map(({ id, name, category }) => [id, category || name]));
}

function differences(first: Copy, second: Copy, base: number): Uint16Array {
  const [one, other] = [classes(first.palette), classes(second.palette)];
  return first.labels.map((label, k) => {
    const mine = one.get(label);
    const theirs = other.get(second.labels[k]!);
    if (mine === undefined && theirs === undefined) return base + DIFFERENCES.length;
    if (theirs === undefined) return base;
    if (mine === undefined) return base + 1;
    return mine === theirs ? base + 3 : base + 2;
  });
}
