import { expect, it } from 'vitest';
import { ENOUGH, Pictures } from './pictures';

const session = (frameRate?: number): XRSession => ({ frameRate }) as unknown as XRSession;

it('sums up pictures of a playing recording, and calls those late that miss a refresh', () => {
  const pictures = new Pictures();
  expect(pictures.sum(session())).toBeNull();
  let now = 0;
  const draw = (milliseconds: number, plays = true): void =>
    pictures.note((now += milliseconds), plays);
  for (let i = 0; i <= 60; i++) draw(11);
  // Pauses are no pictures.
  draw(500, false);
  draw(500);
  for (let i = 0; i < 6; i++) draw(22);
  while (!pictures.enough) draw(11);
  expect(pictures.sum(session())).toEqual({
    told: null, offered: [], found: 90, count: ENOUGH, median_ms: 11, p95_ms: 22, late: 6,
  }); // prettier-ignore
  expect(pictures.sum(session(144))).toMatchObject({ told: 144, late: ENOUGH });
});
