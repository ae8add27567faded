/** Points that are shown now: rays meet them, and strokes may change them. */
import type { PaletteTexture } from '../cloud/picture/palette';
import { DELETED } from '../cloud/points/piece';
import { state } from '../store/state';

/** Whether points of a label value are seen. */
export type Seen = (label: number) => boolean;

export function isDeleted(label: number): boolean {
  return label === DELETED;
}

export function seenIn(palette: PaletteTexture): Seen {
  return (label) => {
    if (label === DELETED) return false;
    return label === 0 ? !state.view.peek().hideUnlabeled : palette.isShown(label);
  };
}

/** Labels that only this viewer hides, for the server to leave alone: 0 is points without one. */
export function locallyHiddenLabels(): number[] {
  const solo = state.solo.peek();
  const others = solo === null ? [] : state.palette.peek().filter(({ id }) => id !== solo);
  const unlabeled = state.view.peek().hideUnlabeled ? [0] : [];
  return [...unlabeled, ...others.map(({ id }) => id)];
}
