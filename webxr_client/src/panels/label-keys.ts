/** The labels under the keyboard: a row is one tab stop, arrows go through rows and into one. */
import { computed, signal } from '@preact/signals';
import { actions } from '../actions';
import { focusedByKeys } from '../desktop/focus';
import { canEdit, state } from '../state';
import { shiftLabel } from './palette-drag';
import { listed } from './palette-list';
import { renaming } from './renaming';

/** The row that had the focus last. */
const visited = signal(0);

/** The label whose row Tab leads to. */
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
  if (event.key === 'Enter' && !inside) actions.selectLabel(id);
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
