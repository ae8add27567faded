import { expect, it } from 'vitest';
import { Path } from './path';

const at = (x: number) => ({ origin: [x, 0, 0], direction: [0, 0, 1] }) as const;

it('keeps a short path as it is, from its first place', () => {
  const path = new Path();
  for (let x = 0; x < 5; x++) path.add(at(x), 0.5);
  expect(path.samples().map(({ origin }) => origin)).toEqual([0, 1, 2, 3, 4].map((x) => [x, 0, -0.5])); // prettier-ignore
  path.clear();
  expect(path.samples()).toEqual([]);
});

it('keeps an even part of a long one', () => {
  const path = new Path();
  for (let x = 0; x < 5000; x++) path.add(at(x));
  const xs = path.samples().map(({ origin }) => origin[0]);
  expect(xs.length).toBeGreaterThan(100);
  expect(xs.length).toBeLessThanOrEqual(256);
  const steps = xs.slice(1).map((x, i) => x - xs[i]!);
  expect(Math.max(...steps) - Math.min(...steps)).toBeLessThanOrEqual(Math.min(...steps));
  expect(xs[0]).toBe(0);
  expect(xs.at(-1)).toBeGreaterThan(4900);
});
