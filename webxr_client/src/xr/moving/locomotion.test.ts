import { describe, expect, it } from 'vitest';
import { blinkAt } from './locomotion';

describe('a teleport', () => {
  it('is black in its first picture and over after a tenth of a second', () => {
    expect(blinkAt(0)).toBe(1);
    expect(blinkAt(70)).toBeGreaterThan(0);
    expect(blinkAt(70)).toBeLessThan(1);
    expect(blinkAt(100)).toBe(0);
    expect(blinkAt(5000)).toBe(0);
  });
});
