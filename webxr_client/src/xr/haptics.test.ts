import { describe, expect, it } from 'vitest';
import { ChangeCounter, strengthOf } from './haptics';

const id = 'a';

describe('what painting feels like', () => {
  it('is stronger the more points change, and nothing when none does', () => {
    const felt = [0, 1, 10, 100, 1000, 100000].map(strengthOf);
    expect(felt[0]).toBe(0);
    expect(felt[1]).toBeGreaterThan(0);
    for (let i = 2; i < 5; i++) expect(felt[i]).toBeGreaterThan(felt[i - 1]!);
    expect(felt[5]).toBe(1);
  });

  it('counts each point once, and the last answer only for what is still new', () => {
    const counter = new ChangeCounter();
    const answers = [10, 10, 25].map((changed) => counter.take({ id, changed, final: false }));
    expect(answers).toEqual([10, 0, 15]);
    expect(counter.take({ id, changed: 26, final: true })).toBe(1);
  });

  it('feels a lasso, which is counted only when it is done', () => {
    expect(new ChangeCounter().take({ id, changed: 400, final: true })).toBe(400);
  });
});
