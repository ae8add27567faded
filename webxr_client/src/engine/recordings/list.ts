/** The list of recordings: search by words of their names, and sorting. */
import { signal } from '@preact/signals';
import { keep, kept } from '../../store/kept';
import type { SequenceSummary } from '../../store/state';

export const ORDERS = ['name', 'frames', 'points', 'progress', 'changed'] as const;
export type Order = (typeof ORDERS)[number];
type Compare = (a: SequenceSummary, b: SequenceSummary) => number;

const KEY = 'pointbrush.recordings-order';
const [keptOrder, keptWay] = (kept(KEY) ?? '').split(' ');

export const order = signal<Order>(ORDERS.find((each) => each === keptOrder) ?? 'name');
export const descending = signal(keptWay === 'down');

/** Order by this; by it already: the other way round. Figures begin with the largest. */
export function chooseOrder(by: Order): void {
  descending.value = by === order.peek() ? !descending.peek() : by !== 'name';
  order.value = by;
  keep(KEY, `${by} ${descending.peek() ? 'down' : 'up'}`);
}

const names = new Intl.Collator(undefined, { numeric: true });
const share = (row: SequenceSummary): number => row.labelled / Math.max(1, row.frames);
const date = ({ changed }: SequenceSummary): number => (changed === null ? 0 : Date.parse(changed));
const COMPARE: Readonly<Record<Order, Compare>> = {
  name: (a, b) => names.compare(a.name, b.name),
  frames: (a, b) => a.frames - b.frames,
  points: (a, b) => a.points - b.points,
  progress: (a, b) => share(a) - share(b),
  changed: (a, b) => date(a) - date(b),
};

/** Return recordings in an order; equal ones by their names. */
export function sorted(
  rows: readonly SequenceSummary[],
  by: Order,
  down: boolean,
): readonly SequenceSummary[] {
  const way = down ? -1 : 1;
  return [...rows].sort((a, b) => way * COMPARE[by](a, b) || COMPARE.name(a, b));
}

/** Return the recordings with all words in their names, in any order. */
export function matching(
  sequences: readonly SequenceSummary[],
  text: string,
): readonly SequenceSummary[] {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  return sequences.filter(({ name, id }) => {
    const named = `${name} ${id}`.toLowerCase();
    return words.every((word) => named.includes(word));
  });
}
