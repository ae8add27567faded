import { describe, expect, it } from 'vitest';
import { Fold } from './fold';

const picture = Float64Array.of(0.1);
const [ray, pinch] = [{ momentary: false }, { momentary: true }];

/** Let pictures pass as a panel does; seconds after which it folded or unfolded, or NaN. */
function after(fold: Fold, by: typeof ray | null, looked = false): number {
  for (let count = 1; count <= 200; count++) {
    if (!fold.update(by, looked, picture)) continue;
    fold.set(!fold.folded);
    return count / 10;
  }
  return NaN;
}

describe('a folded panel', () => {
  it('unfolds for a ray that rests on its handle, and for eyes on one that is held', () => {
    for (const [by, looked] of [
      [ray, false],
      [null, true],
    ] as const) {
      expect(after(new Fold(), by, looked)).toBeGreaterThanOrEqual(0.5);
    }
  });

  it('stays folded where a ray only passes over it, and while nobody calls', () => {
    const fold = new Fold();
    for (let sweep = 0; sweep < 5; sweep++) {
      for (const by of [ray, ray, null]) expect(fold.update(by, false, picture)).toBe(false);
    }
    expect(after(fold, null)).toBeNaN();
  });

  it('takes no press that was meant for its handle', () => {
    const fold = new Fold();
    fold.set(false);
    expect(fold.isJustUnfolded).toBe(true);
    for (let i = 0; i < 4; i++) fold.update(ray, false, picture);
    expect(fold.isJustUnfolded).toBe(false);
  });
});

describe('an open panel', () => {
  it('folds a few seconds after what pointed at it has left, later for what comes to press', () => {
    const left = [ray, pinch].map((by) => {
      const fold = new Fold();
      fold.set(false);
      fold.update(by, false, picture);
      return after(fold, null);
    });
    expect(left[0]).toBeGreaterThan(2);
    expect(left[1]).toBeGreaterThan(left[0]! + 3);
  });

  it('stays while it is looked at', () => {
    const fold = new Fold();
    fold.set(false);
    expect(after(fold, null, true)).toBeNaN();
  });

  it('put away, does not come back before one has looked elsewhere', () => {
    const fold = new Fold();
    fold.set(true);
    expect(after(fold, null, true)).toBeNaN();
    fold.update(null, false, picture);
    expect(after(fold, null, true)).toBeLessThan(1);
  });
});
