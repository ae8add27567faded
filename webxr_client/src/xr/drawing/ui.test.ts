import { describe, expect, it } from 'vitest';
import { contrast, inkOn, LABEL_COLORS } from '../../common/colors';
import { DARK_INK, HIDDEN, LIGHT_INK } from '../../panels/timeline/draw';
import { degrees, LEAST_DEGREES, SIZES } from './sizes';
import { GLASS, INK, LIGHT } from './ui';

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
const LINES = ['line'];

/** Backs of words, as they are seen before the brightest and the darkest room. */
const BACKS: Readonly<Record<keyof typeof WORDS, readonly Color[]>> = {
  back: seen(INK.back),
  raised: seen(INK.back).map((back) => over('#ffffff', back, GLASS.raised)),
  on: [INK.on],
};

function seen(back: Color): Color[] {
  // The veil is drawn as well.
  const veil = (room: Color): Color => over(back, room, GLASS.veil * GLASS.back);
  return (['#000000', '#ffffff'] as const).map((room) => over(back, veil(room), GLASS.back));
}

describe('panels in the room', () => {
  it.each(Object.entries(SIZES))('have capitals of a degree or more: %s', (_name, size) => {
    expect(degrees(size)).toBeGreaterThanOrEqual(LEAST_DEGREES);
  });

  it.each(Object.entries(WORDS))('have words that contrast with %s in any room, lit or not', (back, words) => {
    const light = (color: Color): Color => over(LIGHT.color, color, LIGHT.opacity);
    for (const below of BACKS[back as keyof typeof WORDS]) {
      for (const word of words) {
        // A disabled control need not be read, and does not light up.
        const least = word === 'off' ? 3 : 4.5;
        expect(contrast(INK[word], below), word).toBeGreaterThan(least);
        if (word === 'off') continue;
        expect(contrast(light(INK[word]), light(below)), `${word}, lit`).toBeGreaterThan(least);
      }
    }
    for (const below of BACKS.back) expect(contrast(INK.text, below)).toBeGreaterThan(7);
  }); // prettier-ignore

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

  it('have chips of labels that stand out, with names that contrast with them', () => {
    for (const color of LABEL_COLORS) {
      for (const back of BACKS.back) expect(contrast(color, back)).toBeGreaterThan(2);
      expect(contrast(inkOn(color), color)).toBeGreaterThan(4.5);
    }
  });
});
