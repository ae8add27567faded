/** The labels' rows under keyboard and mouse: keys go through them and into one, the mouse drags one. */
import { arrangeLabels } from '../../engine/labels/palette-files';
import { computed, signal } from '@preact/signals';
import { actions } from '../../store/actions';
import { focusedByKeys } from '../../common/focus';
import { canEdit, state } from '../../store/state';
import { followPointer } from '../parts/drag';
import { listed, renaming, reordered, shownGroups } from '../../store/palette-list';

/** The row that had the focus last. */
const visited = signal(0);

/** The label with the row that Tab focuses. */
export const tabStop = computed(() => {
  const palette = listed.value;
  const has = (id: number): boolean => palette.some((label) => label.id === id);
  if (has(visited.value)) return visited.value;
  return has(state.activeLabel.value) ? state.activeLabel.value : (palette[0]?.id ?? 0);
});

export function onRowFocus(id: number): void {
  visited.value = id;
}

/** Keys on a row, or on a button in it. */
export function onRowKey(event: KeyboardEvent, id: number): void {
  if (event.ctrlKey || event.metaKey || event.shiftKey) return;
  if (event.altKey) {
    moveRow(event, id);
    return;
  }
  const row = event.currentTarget as HTMLElement;
  if (event.target instanceof HTMLInputElement) return;
  const inside = event.target !== row;
  if (event.key === 'Enter' && !inside) actions.labels.selectLabel(id);
  else if (event.key === 'F2' && canEdit.peek()) renaming.value = id;
  else if (event.key === 'Escape' && inside) row.focus();
  else if (!goToRow(event, row) && !goIntoRow(event, row)) return;
  event.preventDefault();
  event.stopPropagation();
}

/** Alt with an arrow moves the label. */
function moveRow(event: KeyboardEvent, id: number): void {
  if (!canEdit.peek() || (event.key !== 'ArrowUp' && event.key !== 'ArrowDown')) return;
  event.preventDefault();
  event.stopPropagation();
  shiftLabel(id, event.key === 'ArrowUp' ? -1 : 1);
  // A row that is moved in the document loses the focus.
  const row = event.currentTarget as HTMLElement;
  requestAnimationFrame(() => row.focus());
}

function goToRow({ key }: KeyboardEvent, row: HTMLElement): boolean {
  const rows = [...row.closest('[role=grid]')!.querySelectorAll<HTMLElement>('.label-row')];
  const at = rows.indexOf(row);
  let to: HTMLElement | undefined;
  if (key === 'ArrowDown') to = rows[at + 1] ?? row;
  else if (key === 'ArrowUp') to = rows[at - 1] ?? row;
  else if (key === 'Home' && focusedByKeys()) to = rows[0];
  else if (key === 'End' && focusedByKeys()) to = rows.at(-1);
  to?.focus();
  return to !== undefined;
}

function goIntoRow({ key, target }: KeyboardEvent, row: HTMLElement): boolean {
  if (!focusedByKeys() || (key !== 'ArrowRight' && key !== 'ArrowLeft')) return false;
  const stops = [row, ...row.querySelectorAll<HTMLElement>('button:not(:disabled)')];
  const to = stops.indexOf(target as HTMLElement) + (key === 'ArrowRight' ? 1 : -1);
  stops[Math.min(stops.length - 1, Math.max(0, to))]!.focus();
  return true;
}

/** Pixels that a press may wander and still be a click. */
const SLACK = 5;

interface Dragged {
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
  const move = ({ clientY }: PointerEvent): void => {
    if (!dragged.peek() && Math.abs(clientY - start) < SLACK) return;
    dragged.value = { id, before: rowBelow(row, clientY) };
  };
  followPointer(event, move, ({ type }) => {
    const at = dragged.peek();
    dragged.value = null;
    if (at && type === 'pointerup') place(at.id, at.before);
  });
}

/** Return the label of the first row of this group with its middle below the pointer, or null. */
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
  if (order.some((one, i) => one !== now[i])) void arrangeLabels(order);
}
