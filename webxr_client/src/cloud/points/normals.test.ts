import { Matrix4 } from 'three';
import { expect, it } from 'vitest';
import { normalColours } from './normals';
import { frameOf } from './testing';

type Vector = [number, number, number];

/** Normals, −1..1, from their colours. */
function normalsOf(points: readonly Vector[], room = new Matrix4()): number[][] {
  const colours = normalColours(frameOf(points).pieces, room);
  return points.map((_, i) => [0, 1, 2].map((k) => (colours[3 * i + k]! - 128) / 127));
}

/** The part of the points with a normal within about 15 degrees of the true one. */
function right(found: readonly number[][], truth: (i: number) => Vector): number {
  const near = found.filter((n, i) => {
    const [x, y, z] = truth(i);
    return n[0]! * x + n[1]! * y + n[2]! * z > 0.966;
  });
  return near.length / found.length;
}

/** Even rows over a square, millimetres, in the order of a curve that keeps neighbours together. */
function plane(size: number, height: (i: number) => number): Vector[] {
  const spread = (n: number): number => [0, 1, 2, 3, 4, 5].reduce((sum, b) => sum | (((n >> b) & 1) << (2 * b)), 0); // prettier-ignore
  const cells = Array.from({ length: size * size }, (_, i) => [i % size, Math.floor(i / size)] as const); // prettier-ignore
  cells.sort((a, b) => spread(a[0]) + 2 * spread(a[1]) - spread(b[0]) - 2 * spread(b[1]));
  return cells.map(([x, y], i) => [500 + 10 * x, 500 + 10 * y, 2000 + height(i)]);
}

it('has one direction all over a plane, towards the sensor, through noise as well', () => {
  const noise = (i: number): number => ((i * 7919) % 5) - 2;
  for (const height of [() => 0, noise]) {
    expect(right(normalsOf(plane(40, height)), () => [0, 0, -1])).toBeGreaterThan(0.95);
  }
  // The room turns it: the side that faced the sensor faces up.
  const up = new Matrix4().makeRotationX(Math.PI / 2);
  expect(
    right(
      normalsOf(
        plane(40, () => 0),
        up,
      ),
      () => [0, 1, 0],
    ),
  ).toBeGreaterThan(0.95);
});

it('follows a sphere, and is the same however often it is asked', () => {
  const middle: Vector = [1500, 1500, 3000];
  const points: Vector[] = Array.from({ length: 3000 }, (_, i) => {
    const z = 1 - (2 * i + 1) / 3000;
    const turn = i * Math.PI * (3 - Math.sqrt(5));
    const r = Math.sqrt(1 - z * z);
    return [r * Math.cos(turn), r * Math.sin(turn), z].map((part, k) => Math.round(middle[k]! + 500 * part)) as Vector; // prettier-ignore
  });
  // The side that a sensor sees.
  const seen = points.filter((p) => p.reduce((sum, v, k) => sum + v * (v - middle[k]!), 0) < -3e5);
  const found = normalsOf(seen);
  const truth = (i: number): Vector => seen[i]!.map((v, k) => (v - middle[k]!) / 500) as Vector;
  expect(right(found, truth)).toBeGreaterThan(0.9);
  expect(normalsOf(seen)).toEqual(found);
});

it('leaves points grey that make no surface', () => {
  expect(normalsOf([[0, 0, 0], [60000, 0, 0], [0, 60000, 0]])).toEqual([[0, 0, 0], [0, 0, 0], [0, 0, 0]]); // prettier-ignore
});
