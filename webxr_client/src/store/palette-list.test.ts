import { describe, expect, it } from 'vitest';
import type { Label } from '../protocol/messages';
import { inGroups, keyOf, matching, reordered, worthGrouping } from './palette-list';

function label(id: number, name: string, category = ''): Label {
  return { id, name, category, color: '#ffffff', locked: false, visible: true };
}

const PALETTE = [
  label(1, 'pin 1', 'pin'),
  label(2, 'left hand', 'body'),
  label(3, 'pin 2', 'pin'),
  label(4, 'right hand', 'body'),
];

describe('the palette', () => {
  it('is searched by all words, in name or category', () => {
    const found = (words: string): number[] => matching(PALETTE, words).map(({ id }) => id);
    expect(found('HAND left')).toEqual([2]);
    expect(found('body')).toEqual([2, 4]);
    expect(found(' ')).toEqual([1, 2, 3, 4]);
    expect(found('foot')).toEqual([]);
  });

  it('has headings only where they say something', () => {
    expect(worthGrouping(PALETTE)).toBe(true);
    expect(worthGrouping(PALETTE.slice(0, 3))).toBe(false);
    expect(worthGrouping(PALETTE.map((each) => ({ ...each, category: '' })))).toBe(false);
    const groups = inGroups(PALETTE, true).map((group) => group.labels.map(({ id }) => id));
    expect(groups).toEqual([[1, 3], [2, 4]]); // prettier-ignore
  });

  it('is put in another order', () => {
    expect(reordered([1, 2, 3, 4], 4, 2)).toEqual([1, 4, 2, 3]);
    expect(reordered([1, 2, 3, 4], 1, null)).toEqual([2, 3, 4, 1]);
    expect(reordered([1, 2, 3, 4], 2, 2)).toEqual([1, 2, 3, 4]);
  });

  it('numbers eighteen labels', () => {
    expect([1, 9, 10, 18, 19].map(keyOf)).toEqual(['1', '9', '⇧1', '⇧9', null]);
  });
});
