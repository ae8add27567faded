/** Which labels one looks at now, and their colours. */
import { Color } from 'three';
import { state } from '../state';

const scratch = new Color();

/** Whether a label's objects are shown: it is visible, or solo. */
export function isShown(label: number): boolean {
  const solo = state.solo.peek();
  if (solo !== null) return solo === label;
  for (const entry of state.palette.peek()) if (entry.id === label) return entry.visible;
  return false;
}

/** A label's colour, linear as three.js mixes it; the same object each time. */
export function colorOf(label: number): Color {
  for (const entry of state.palette.peek()) {
    if (entry.id === label) return scratch.set(entry.color);
  }
  return scratch.set('#ffffff');
}
