import { Matrix4 } from 'three';
import { describe, expect, it } from 'vitest';
import { contrast } from '../../common/colors';
import { colorModeOf } from '../picture/material';
import { POINT_VERTEX } from '../picture/shaders';
import { spreadOf } from './spread';
import { frameOf } from './testing';

type Vector = [number, number, number];

describe('what ramps run over', () => {
  it('are the heights of most points, strays left out', () => {
    const wall: Vector[] = Array.from({ length: 1000 }, (_, i) => [0, 1000 + i, 0]);
    const strays: Vector[] = Array.from({ length: 10 }, () => [0, 60_000, 0]);
    const room = new Matrix4().makeTranslation(0, -1, 0);
    const frame = frameOf([...strays, ...wall]);
    const [low, high] = spreadOf(frame, room)!.height;
    expect(low).toBeCloseTo(0.01, 1);
    expect(high).toBeCloseTo(0.99, 1);
  });

  it('are the intensities that the frame has', () => {
    const frame = frameOf(Array.from({ length: 100 }, () => [0, 0, 0] as Vector));
    const { words } = frame.pieces[0]!;
    for (let i = 0; i < 100; i++) words[6 * i + 4] = (i < 50 ? 20 : 40) << 8;
    const [low, high] = spreadOf(frame, new Matrix4())!.intensity;
    expect([low, high].map((value) => Math.round(value * 255))).toEqual([20, 40]);
  });

  it('show a recording by what it has', () => {
    expect(colorModeOf('rgb', ['rgb'])).toBe('rgb');
    expect(colorModeOf('rgb', ['intensity'])).toBe('intensity');
    expect(colorModeOf('rgb', [])).toBe('height');
  });
});

describe('the ramp', () => {
  /** The shader's polynomial, evaluated here. */
  function ramp(t: number): string {
    const rows = [...POINT_VERTEX.matchAll(/c\d = vec3\(([^)]*)\)/g)].map((match) =>
      match[1]!.split(',').map(Number),
    );
    const start = Number(/mix\(([\d.]+), 1\.0/.exec(POINT_VERTEX)![1]);
    const at = start + (1 - start) * t;
    const channel = (k: number): number => rows.reduceRight((sum, row) => row[k]! + at * sum, 0);
    const hex = (value: number): string =>
      Math.round(255 * Math.min(1, Math.max(0, value)))
        .toString(16)
        .padStart(2, '0');
    return `#${[0, 1, 2].map((k) => hex(channel(k))).join('')}`;
  }

  it('is legible on the dark room from end to end', () => {
    for (let t = 0; t <= 1; t += 0.05) {
      expect(contrast(ramp(t), '#0b0e12')).toBeGreaterThan(3);
    }
  });
});
