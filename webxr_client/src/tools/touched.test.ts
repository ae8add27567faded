import { describe, expect, it } from 'vitest';
import { Touched } from './touched';

/** Numbers that repeat and come in no order, the same in every run. */
function numbers(count: number, below: number): number[] {
  let state = 1;
  return Array.from({ length: count }, () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state % below;
  });
}

describe('the points of a stroke', () => {
  it('are met once each, and kept in order however they come', () => {
    const touched = new Touched();
    const expected = new Set<number>();
    for (const [i, point] of numbers(9000, 6000).entries()) {
      const first = !expected.has(point);
      expect(touched.meet(point)).toBe(first);
      if (first) touched.take(point);
      expected.add(point);
      if (i % 1877 === 0) touched.settle();
    }
    expect(touched.settle()).toBe(true);
    expect(touched.settle()).toBe(false);
    expect(touched.size).toBe(expected.size);
    const sorted = [...expected].sort((a, b) => a - b);
    expect([...touched.numbers.subarray(0, touched.size)]).toEqual(sorted);
  });

  it('that stay as they are are met and not taken', () => {
    const touched = new Touched();
    expect(touched.meet(0)).toBe(true);
    expect(touched.meet(0)).toBe(false);
    expect(touched.settle()).toBe(false);
    expect(touched.size).toBe(0);
  });
});
