import { describe, expect, it } from 'vitest';
import type { Label } from '../../protocol/messages';
import { labelBeside, labelLean } from './buttons';
import { DEVICES } from './devices';

const palette = [3, 7, 5].map((id) => ({ id }) as Label);

describe('a pad for labels', () => {
  it('walks through the labels as they are listed, round and round', () => {
    expect([3, 7, 5].map((id) => labelBeside(palette, id, 1))).toEqual([7, 5, 3]);
    expect([3, 7, 5].map((id) => labelBeside(palette, id, -1))).toEqual([5, 3, 7]);
  });

  it('begins with the first or the last when no label of the palette is active', () => {
    expect(labelBeside(palette, 0, 1)).toBe(3);
    expect(labelBeside(palette, 0, -1)).toBe(5);
    expect(labelBeside([], 4, 1)).toBe(4);
  });

  const held = (id: string, y: number, labels = 0) => {
    const device = DEVICES.find((one) => one.id === id)!;
    return { device, labels, pad: { x: 0, y, click: false } };
  };

  it('of a stick switches labels only while its ray is on the palette, or by a chord', () => {
    for (const part of ['alone', 'brush', 'other'] as const) {
      for (const y of [1, -1]) {
        expect(labelLean(held('touch', y), part, false)).toBe(0);
        expect(labelLean(held('touch', y), part, true)).toBe(y);
      }
      expect(labelLean(held('touch', 0, -1), part, false)).toBe(-1);
    }
  });

  it('of a wand switches labels by its own quadrants, both ways where it is alone', () => {
    expect([1, -1].map((y) => labelLean(held('vive', y), 'alone', false))).toEqual([1, -1]);
    expect([1, -1].map((y) => labelLean(held('vive', y), 'other', false))).toEqual([0, -1]);
    expect([1, -1].map((y) => labelLean(held('vive', y), 'brush', false))).toEqual([0, 0]);
  });
});
