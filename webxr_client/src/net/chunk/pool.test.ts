import { expect, it } from 'vitest';
import { BufferPool } from './pool';

it('serves the parts of a frame again from the memory of one before, in any order', () => {
  const pool = new BufferPool(1 << 22);
  const sizes = [868_352, 493_584, 493_584];
  const first = sizes.map((size) => pool.take(size));
  for (const order of [first, [...first].reverse()]) {
    for (const buffer of order) pool.give(buffer);
    const reused = [...sizes].reverse().map((size) => pool.take(size));
    expect(reused.every((buffer) => first.includes(buffer))).toBe(true);
  }
});
