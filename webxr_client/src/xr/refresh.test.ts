import { describe, expect, it } from 'vitest';
import { RefreshRate } from './refresh';

/** The rate that is measured on a display where every `late`-th picture takes two refreshes. */
function measured(hertz: number, late: number, jitter = 0): number {
  const refresh = new RefreshRate();
  let now = 1000;
  for (let i = 1; !refresh.note(now + jitter * Math.sin(7 * i)); i++) {
    now += (i % late === 0 ? 2 : 1) * (1000 / hertz);
  }
  return refresh.rate;
}

describe('the measured refresh rate', () => {
  it.each([60, 72, 80, 90, 120, 144])('of a display at %d Hz is its own', (hertz) => {
    expect(measured(hertz, 1000)).toBe(hertz);
    expect(measured(hertz, 3, 0.3)).toBe(hertz);
  });

  it('is the display’s where a busy page draws every other picture only', () => {
    expect(measured(90, 1)).toBe(90);
    expect(measured(72, 1)).toBe(72);
  });
});
