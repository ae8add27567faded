/** Rows of the palette are dragged to another place; the server keeps the order. */
import { signal } from '@preact/signals';
import { actions } from '../actions';
import { canEdit, state } from '../state';
import { listed, shownGroups } from './palette-list';
import { reordered } from './palette-order';

/** Pixels that a press may wander and still be a click. */
const SLACK = 5;

export interface Dragged {
  readonly id: number;
  /** The label before which it would be put; null: behind the last of its group. */
  readonly before: number | null;
}

export const dragged = signal<Dragged | null>(null);

/** Begin to drag a row with the mouse or a pen; a finger scrolls. */
export function onRowDown(event: PointerEvent, id: number): void {
  if (event.button !== 0 || event.pointerType === 'touch' || !canEdit.peek()) return;
  if ((event.target as Element).closest('button, input')) return;
  const row = event.currentTarget as HTMLElement;
  const { clientY: start } = event;
  // A fast drag leaves the row at once.
  row.setPointerCapture(event.pointerId);
  const abort = new AbortController();
  const { signal } = abort;
  const end = (): void => {
    abort.abort();
    dragged.value = null;
  };
  const move = ({ clientY }: PointerEvent): void => {
    if (!dragged.peek() && Math.abs(clientY - start) < SLACK) return;
    dragged.value = { id, before: rowBelow(row, clientY) };
  };
  const drop = (): void => {
    const at = dragged.peek();
    end();
    if (at) place(at.id, at.before);
  };
  row.addEventListener('pointermove', move, { signal });
  row.addEventListener('pointerup', drop, { signal });
  row.addEventListener('pointercancel', end, { signal });
}

/** The label of the first row of this group whose middle lies below the pointer, or null. */
function rowBelow(row: HTMLElement, y: number): number | null {
  const rows = [...row.parentElement!.querySelectorAll<HTMLElement>('.label-row[data-label]')];
  const below = rows.find((one) => {
    const { top, height } = one.getBoundingClientRect();
    return y < top + height / 2;
  });
  return below ? Number(below.dataset['label']) : null;
}

/** Move a label one place up (−1) or down (1) in its group. */
export function shiftLabel(id: number, by: 1 | -1): void {
  const ids = groupOf(id);
  const at = ids.indexOf(id);
  if (ids[at + by] === undefined) return;
  place(id, (by < 0 ? ids[at - 1] : ids[at + 2]) ?? null);
}

function groupOf(id: number): readonly number[] {
  const group = shownGroups.peek().find(({ labels }) => labels.some((label) => label.id === id));
  return group?.labels.map((label) => label.id) ?? [];
}

/** Put a label before another one, or (null) behind the last of its group. */
function place(id: number, before: number | null): void {
  const ids = listed.peek().map((label) => label.id);
  const last = groupOf(id).at(-1);
  const behind = last === undefined ? null : (ids[ids.indexOf(last) + 1] ?? null);
  const order = reordered(ids, id, before ?? behind);
  const now = state.palette.peek().map((label) => label.id);
  if (order.some((one, i) => one !== now[i])) void actions.arrangeLabels(order);
}
