import { describe, expect, it } from 'vitest';
import type { Label } from '../protocol/messages';
import { labelBeside, labelLean } from './buttons';

const palette = [3, 7, 5].map((id) => ({ id }) as Label);

describe('the palette hand’s pad', () => {
  it('walks through the labels as they are listed, round and round', () => {
    expect([3, 7, 5].map((id) => labelBeside(palette, id, 1))).toEqual([7, 5, 3]);
    expect([3, 7, 5].map((id) => labelBeside(palette, id, -1))).toEqual([5, 3, 7]);
  });

  it('begins with the first or the last when no label of the palette is active', () => {
    expect(labelBeside(palette, 0, 1)).toBe(3);
    expect(labelBeside(palette, 0, -1)).toBe(5);
    expect(labelBeside([], 4, 1)).toBe(4);
  });

  it('is for labels while one looks at the palette, else only where no walking needs it', () => {
    expect(labelLean(1, true, true)).toBe(1);
    expect(labelLean(1, false, false)).toBe(0);
    expect(labelLean(-1, false, false)).toBe(-1);
    expect(labelLean(-1, false, true)).toBe(0);
  });
});
