/**
 * Keys go to a control that was reached with the keyboard, but not to a clicked one: a click on
 * a button is followed by keys for the picture.
 */
let last: 'keys' | 'pointer' = 'pointer';
let reached = false;

if (typeof document !== 'undefined') {
  const listen = (type: string, run: () => void): void => {
    document.addEventListener(type, run, true);
  };
  listen('keydown', () => (last = 'keys'));
  listen('pointerdown', () => (last = 'pointer'));
  listen('focusin', () => (reached = last === 'keys'));
}

/** Whether the focus came to where it is by a key. */
export function focusedByKeys(): boolean {
  return reached && document.activeElement !== document.body;
}

const SLIDER_KEYS = new Set([
  'ArrowLeft',
  'ArrowRight',
  'ArrowUp',
  'ArrowDown',
  'Home',
  'End',
  'PageUp',
  'PageDown',
]);

/** Whether a key is for the control that has the focus, and not a shortcut. */
export function isForControl({ key, target }: KeyboardEvent): boolean {
  if (!(target instanceof HTMLElement)) return false;
  if (target instanceof HTMLInputElement && target.type === 'range') return SLIDER_KEYS.has(key);
  if (key === 'Tab') return focusedByKeys() || target === document.body;
  return key === ' ' && focusedByKeys() && target.matches('button, input, summary, a');
}

/** Return the keys to the picture when the mouse enters it. */
export function releaseSlider(): void {
  const { activeElement } = document;
  if (activeElement instanceof HTMLInputElement && activeElement.type === 'range') {
    activeElement.blur();
  }
}
