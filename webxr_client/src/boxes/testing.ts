/** Expectations that tests of boxes share. */
import { expect } from 'vitest';

/** Expect numbers to be alike to a millionth. */
export function near(found: readonly number[], expected: readonly number[]): void {
  found.forEach((value, i) => {
    expect(value).toBeCloseTo(expected[i]!, 6);
  });
}
