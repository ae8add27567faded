/** One tab stop for several controls: arrows go from one to the next. */
import { focusedByKeys } from '../desktop/focus';

const STEPS: Readonly<Record<string, number>> = {
  ArrowRight: 1,
  ArrowDown: 1,
  ArrowLeft: -1,
  ArrowUp: -1,
};

/** Return the place to which a key leads in a list of `length`, from `at`; null: another key. */
export function nextIndex(key: string, at: number, length: number): number | null {
  if (length === 0) return null;
  if (key === 'Home') return 0;
  if (key === 'End') return length - 1;
  const step = STEPS[key];
  return step === undefined ? null : (at + step + length) % length;
}

/** Handler of a radio group's keys: arrows choose the next one. */
export function roveRadios(event: KeyboardEvent): void {
  if (!focusedByKeys() || event.ctrlKey || event.altKey || event.metaKey) return;
  const group = event.currentTarget as HTMLElement;
  const radios = [...group.querySelectorAll<HTMLElement>('[role=radio]:not(:disabled)')];
  const to = nextIndex(event.key, radios.indexOf(event.target as HTMLElement), radios.length);
  if (to === null) return;
  event.preventDefault();
  radios[to]!.focus();
  radios[to]!.click();
}
