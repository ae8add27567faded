import { describe, expect, it } from 'vitest';
import { gripOf } from './grip';
import type { Shape } from './shape';

const CAR: Shape = { size: [4, 2, 1.5], centre: [0, 0, 0], quaternion: [0, 0, 0, 1] };

describe('what a hand holds of a box', () => {
  it('is the corner or the middle of the face that it is at', () => {
    expect(gripOf(CAR, [2.05, 1.02, 0.7], 0.1)).toEqual([1, 1, 1]);
    expect(gripOf(CAR, [-1.9, 0.1, 0], 0.1)).toEqual([-1, 0, 0]);
  });

  it('is all of it elsewhere in the box, and nothing beside it', () => {
    expect(gripOf(CAR, [1, 0.3, 0.1], 0.1)).toBe('all');
    expect(gripOf(CAR, [2.6, 0, 0], 0.1)).toBeNull();
  });
});
