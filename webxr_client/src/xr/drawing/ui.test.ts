import { describe, expect, it } from 'vitest';
import { contrast, LABEL_COLORS } from '../../common/colors';
import { DARK_INK, HIDDEN, LIGHT_INK } from '../../panels/timeline/draw';
import { degrees, LEAST_DEGREES, SIZES } from './sizes';
import { INK, LIGHT } from './ui';

type Color = `#${string}`;

/** One colour seen through another, as the browser mixes them. */
function over(top: Color, below: Color, opacity: number): Color {
  const channel = (color: Color, k: number): number =>
    Number.parseInt(color.slice(1 + 2 * k, 3 + 2 * k), 16);
  const mixed = [0, 1, 2].map((k) =>
    Math.round(opacity * channel(top, k) + (1 - opacity) * channel(below, k)),
  );
  return `#${mixed.map((value) => value.toString(16).padStart(2, '0')).join('')}`;
}

/** Map each word to the back that it stands on. */
const WORDS = {
  back: ['text', 'quiet', 'off', 'accent', 'bad', 'good', 'warn'],
  raised: ['text', 'quiet', 'off', 'warn'],
  on: ['onText', 'warn'],
} as const;
const LINES = ['line', 'edge'];

describe('panels in the room', () => {
  it.each(Object.entries(SIZES))('have capitals of a degree or more: %s', (_name, size) => {
    expect(degrees(size)).toBeGreaterThanOrEqual(LEAST_DEGREES);
  });

  it.each(Object.entries(WORDS))('have words that contrast with %s, lit or not', (back, words) => {
    const below = INK[back as keyof typeof WORDS];
    for (const word of words) {
      expect(contrast(INK[word], below), word).toBeGreaterThan(4.5);
      // A disabled control does not light up.
      if (word === 'off') continue;
      const light = (color: Color): Color => over(LIGHT.color, color, LIGHT.opacity);
      expect(contrast(light(INK[word]), light(below)), `${word}, lit`).toBeGreaterThan(4.5);
    }
    expect(contrast(INK.text, INK.back)).toBeGreaterThan(7);
  });

  it('know all their colours', () => {
    const known = new Set<string>([...Object.entries(WORDS).flat(2), ...LINES]);
    expect(Object.keys(INK).filter((name) => !known.has(name))).toEqual([]);
  });

  it.each([DARK_INK, LIGHT_INK])('have names of labels that contrast with the strips', (ink) => {
    for (const back of [ink.back, ink.lane, ink.laneActive]) {
      for (const word of [ink.text, ink.textStrong]) {
        expect(contrast(word, back)).toBeGreaterThan(4.5);
      }
    }
    const hidden = over(ink.text, ink.back, HIDDEN);
    expect(contrast(hidden, ink.back)).toBeGreaterThan(4.5);
  });

  it('have colours of labels that stand out', () => {
    for (const color of LABEL_COLORS) expect(contrast(color, INK.raised)).toBeGreaterThan(3);
  });
});
