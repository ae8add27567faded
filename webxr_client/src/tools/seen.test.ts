import { afterEach, describe, expect, it } from 'vitest';
import { PaletteTexture } from '../cloud/picture/palette';
import { DELETED } from '../cloud/points/piece';
import type { Label } from '../protocol/messages';
import { patch, state } from '../store/state';
import { locallyHiddenLabels, seenIn } from './seen';

const label = (id: number, visible: boolean): Label =>
  ({ id, name: `${id}`, category: '', color: '#808080', locked: false, visible }); // prettier-ignore

describe('what one sees', () => {
  const palette = new PaletteTexture();
  const seen = seenIn(palette);
  const labels = [label(1, true), label(2, false), label(3, true)];

  const show = (solo: number | null): void => {
    state.palette.value = labels;
    state.solo.value = solo;
    palette.set(labels, solo, []);
  };

  afterEach(() => {
    show(null);
    patch(state.view, { hideUnlabeled: false });
  });

  it('is all but deleted points and hidden labels', () => {
    show(null);
    expect([0, 1, 2, 3, DELETED].filter(seen)).toEqual([0, 1, 3]);
    expect(locallyHiddenLabels()).toEqual([]);
    expect([1, 2, 3].filter((id) => palette.isSpared(id))).toEqual([2]);
  });

  it('is one label when it is solo, and what is hidden for all stays hidden', () => {
    show(3);
    expect([0, 1, 2, 3].filter(seen)).toEqual([0, 3]);
    expect(locallyHiddenLabels()).toEqual([1, 2]);
    show(2);
    expect([0, 1, 2, 3].filter(seen)).toEqual([0]);
  });

  it('is without unlabelled points where these are hidden', () => {
    show(null);
    patch(state.view, { hideUnlabeled: true });
    expect([0, 1].filter(seen)).toEqual([1]);
    expect(locallyHiddenLabels()).toEqual([0]);
  });
});
