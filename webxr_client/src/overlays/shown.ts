/** Labels that are shown now, and their colours: looked up for every frame that plays. */
import { Color } from 'three';
import type { Label } from '../protocol/messages';
import { state } from '../store/state';

const WHITE = new Color('#ffffff');
const known = new Map<number, { readonly color: Color; readonly visible: boolean }>();
let palette: readonly Label[] | null = null;

function look(label: number): { readonly color: Color; readonly visible: boolean } | undefined {
  const now = state.palette.peek();
  if (now !== palette) {
    palette = now;
    known.clear();
    for (const { id, color, visible } of now) known.set(id, { color: new Color(color), visible });
  }
  return known.get(label);
}

/** Whether a label's objects are shown: it is visible, or solo. */
export function isShown(label: number): boolean {
  const solo = state.solo.peek();
  return solo === null ? (look(label)?.visible ?? false) : solo === label;
}

/** A label's colour, linear as three.js mixes it; not to be changed. */
export function colorOf(label: number): Color {
  return look(label)?.color ?? WHITE;
}
