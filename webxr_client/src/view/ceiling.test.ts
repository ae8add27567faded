import { Matrix4 } from 'three';
import { describe, expect, it } from 'vitest';
import { frameAround } from '../cloud/points/testing';
import { underCeiling } from './ceiling';

type Vector = [number, number, number];
type Height = number | ((x: number, z: number) => number);

/** A level surface, millimetres: of `half` width round a place, `height` above the ground. */
function level(height: Height, half = 2500, [x0, z0] = [0, 0]): Vector[] {
  return Array.from({ length: 900 }, (_, i): Vector => {
    const x = x0 + ((i % 30) / 14.5 - 1) * half;
    const z = z0 + (Math.floor(i / 30) / 14.5 - 1) * half;
    return [x, typeof height === 'number' ? height : height(x, z), z].map(Math.round) as Vector;
  });
}

/** Four walls without the `open` sides. */
function walls(height: number, half = 2500, sides = 4, [x0, z0] = [0, 0]): Vector[] {
  return Array.from({ length: 300 * sides }, (_, i): Vector => {
    const [along, y] = [((i % 300) % 25) / 12 - 1, (Math.floor((i % 300) / 25) / 11) * height];
    const place = [[along, -1], [-1, along], [1, along], [along, 1]][Math.floor(i / 300)]!; // prettier-ignore
    return [x0 + place[0]! * half, y, z0 + place[1]! * half].map(Math.round) as Vector;
  });
}

const ceiling = (...parts: Vector[][]): number | null =>
  underCeiling(frameAround(parts.flat()), new Matrix4());

describe('a plan', () => {
  it.each([
    ['a room', [level(0), walls(2500), level(2500)]],
    ['a furnished room', [level(0), level(750, 1200), walls(2500), level(2500)]],
    ['a room that a camera in its fourth wall sees', [level(0), walls(2500, 2500, 3), level(2500)]],
    ['a hall', [level(0, 12000), walls(2500, 12000), level(2500, 12000)]],
  ])('ends below the ceiling of %s', (_, parts) => {
    const height = ceiling(...parts)!;
    expect(height).toBeGreaterThan(2.1);
    expect(height).toBeLessThan(2.5);
  });

  const crowns = level((x, z) => 4000 + 900 * Math.sin(x / 900) * Math.cos(z / 700), 9000);
  it.each([
    ['a room without a ceiling', [level(0), walls(2500)]],
    ['a table', [level(0), walls(2500), level(800)]],
    ['houses from the air', [level(0, 28000), ...[-18000, 0, 18000].flatMap((x) => [level(6000, 8000, [x, x]), walls(6000, 8000, 4, [x, x])])]], // prettier-ignore
    ['a flat roof over a street', [level(0, 9000), level(5000, 5500), walls(5000, 5500)]],
    ['a carport', [level(0, 4000), level(2500, 3000)]],
    ['crowns of trees', [level(0, 9000), crowns, walls(4500, 9000)]],
    ['a roof with its walls, from outside', [walls(3000), level(3000)]],
    ['one point', [[[0, 0, 0] as Vector]]],
    ['nothing', []],
  ])('shows all of %s', (_, parts) => {
    expect(ceiling(...parts)).toBeNull();
  });
});
