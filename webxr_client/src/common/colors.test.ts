import { describe, expect, it } from 'vitest';
import { apart, contrast, difference, inkOn, LABEL_COLORS, lightOf, oklab, SAFE_COLORS, suggestColor, suggestName, type Rgb } from './colors'; // prettier-ignore
import { clock, count, metres, shortCount } from './format';

type Cones = readonly [Rgb, Rgb, Rgb];
/** Light as seen without one kind of cones, of linear red, green, blue (Machado et al. 2009). */
const EYES: readonly Cones[] = [
  [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
  [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]],
  [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.3039]],
]; // prettier-ignore

function seenBy(eye: Cones, [r, g, b]: Rgb): Rgb {
  const part = ([x, y, z]: Rgb): number => Math.min(1, Math.max(0, x * r + y * g + z * b));
  return [part(eye[0]), part(eye[1]), part(eye[2])];
}

/** Visible difference to the eye that sees it least: with all cones, or without one kind of them. */
function leastDifference(one: string, other: string): number {
  const [a, b] = [lightOf(one), lightOf(other)];
  const blind = EYES.map((eye) => apart(oklab(seenBy(eye, a)), oklab(seenBy(eye, b))));
  return Math.min(difference(one, other), ...blind);
}

describe('suggested colours', () => {
  it('differ from those in use, as long as there are any', () => {
    const taken: string[] = [];
    for (let i = 0; i < LABEL_COLORS.length; i++) taken.push(suggestColor(taken));
    expect(new Set(taken).size).toBe(LABEL_COLORS.length);
    const [first, second] = taken;
    expect(difference(first!, second!)).toBeGreaterThan(0.2);
  });

  it('go on with others that differ when all are in use', () => {
    const taken: string[] = [];
    for (let i = 0; i < 40; i++) taken.push(suggestColor(taken));
    expect(new Set(taken).size).toBe(40);
    for (const [i, color] of taken.entries()) {
      expect(contrast(color, '#12161b')).toBeGreaterThan(4.5);
      for (const other of taken.slice(0, i)) expect(difference(color, other)).toBeGreaterThan(0.03);
    }
  });

  it('are legible on the panels and under their own ink', () => {
    for (const color of LABEL_COLORS) {
      expect(contrast(color, '#12161b')).toBeGreaterThan(4.5);
      expect(contrast(color, inkOn(color))).toBeGreaterThan(4.5);
    }
  });
});

describe('colours for colour-blind eyes', () => {
  const least = (colors: readonly string[]): number =>
    Math.min(
      ...colors.flatMap((one, i) =>
        colors.slice(i + 1).map((other) => leastDifference(one, other)),
      ),
    );

  it('are told apart without any one kind of cones, where the usual ones are not', () => {
    expect(least(LABEL_COLORS.slice(0, SAFE_COLORS.length))).toBeLessThan(0.01);
    expect(least(SAFE_COLORS)).toBeGreaterThan(0.07);
    for (const color of SAFE_COLORS) expect(contrast(color, '#12161b')).toBeGreaterThan(2.4);
  });

  it('are suggested to who wants them', () => {
    const taken: string[] = [];
    for (let i = 0; i < SAFE_COLORS.length; i++) taken.push(suggestColor(taken, SAFE_COLORS));
    expect(taken.sort()).toEqual([...SAFE_COLORS].sort());
  });
});

describe('suggested names', () => {
  it('count on', () => {
    expect(suggestName('pin', ['pin 1', 'Pin 7', 'pinball 9'])).toBe('pin 8');
    expect(suggestName('a+b', ['a+b 2'])).toBe('a+b 3');
    expect(suggestName('', [])).toBe('label 1');
  });
});

describe('numbers', () => {
  it('read easily', () => {
    expect(count(1234567)).toBe('1\u202f234\u202f567');
    expect([9999, 217088, 1234567].map(shortCount)).toEqual([
      '9\u202f999',
      '217\u202fk',
      '1.23\u202fM',
    ]);
    expect([0.005, 0.05, 0.25, 1.5, 12].map(metres)).toEqual([
      '0.5 cm',
      '5.0 cm',
      '25 cm',
      '1.50 m',
      '12.0 m',
    ]);
    expect(clock(83.4)).toBe('1:23.40');
  });
});
