import type { Vec } from '../../store/types';
import { describe, expect, it } from 'vitest';
import { hiddenSensors } from '../../store/sensors';
import { boundBlocks } from './blocks';
import { CloudFrame } from './frame';
import { insideOutline } from './inside';
import { DELETED } from './piece';
import { alongRay, firstHit, inBox, inCapsule } from './pick';
import { frameOf, segmentOf, wall } from './testing';

/** Two walls, 1 m and 2 m away. */
const frame = frameOf(wall(40, 1000), wall(40, 2000));
const forward: Vec = [0, 0, 1];

function collect(visit: (found: (point: number) => void) => void): number[] {
  const points: number[] = [];
  visit((point) => points.push(point));
  return points.sort((a, b) => a - b);
}

/** Every point, tested one by one. */
function brute(keep: (x: number, y: number, z: number) => boolean): number[] {
  const points: number[] = [];
  for (const piece of frame.pieces) {
    for (let i = 0; i < piece.count; i++) {
      const [x, y, z] = [0, 1, 2].map((k) => piece.words[i * 6 + k]! * 0.001) as [
        number,
        number,
        number,
      ];
      if (keep(x, y, z)) points.push(piece.first + i);
    }
  }
  return points;
}

describe('the first surface a ray meets', () => {
  it('is the nearer wall, between its points too', () => {
    const hit = firstHit(frame, [0.205, 0.205, 0], forward, 0.05);
    expect(hit?.distance).toBeCloseTo(1, 3);
    expect(hit!.point).toBeLessThan(1600);
  });

  it('is nothing behind, and nothing beside', () => {
    expect(firstHit(frame, [0.2, 0.2, 3], forward, 0.05)).toBeNull();
    expect(firstHit(frame, [3, 3, 0], forward, 0.05)).toBeNull();
  });

  it('passes through deleted points', () => {
    const holed = frameOf(wall(40, 1000), wall(40, 2000));
    const front = Uint32Array.from({ length: 1600 }, (_, i) => i);
    holed.setOverlay('stroke', { indices: front, values: Uint16Array.of(DELETED) });
    expect(firstHit(holed, [0.2, 0.2, 0], forward, 0.05)?.distance).toBeCloseTo(2, 3);
  });

  it('lets a brush wider than the gap catch a thin thing', () => {
    expect(firstHit(frame, [-0.04, 0.2, 0], forward, 0.05)?.distance).toBeCloseTo(1, 2);
    expect(firstHit(frame, [-0.06, 0.2, 0], forward, 0.05)).toBeNull();
  });
});

describe('blocks', () => {
  it('hold all their points, and no more room than those need', () => {
    const [piece] = frame.pieces;
    const blocks = boundBlocks(piece!.words, piece!.count);
    for (let block = 0; block * 256 < piece!.count; block++) {
      const points = Array.from(
        { length: Math.min(256, piece!.count - block * 256) },
        (_, i) => block * 256 + i,
      );
      for (let k = 0; k < 3; k++) {
        const values = points.map((point) => piece!.words[point * 6 + k]!);
        expect(blocks[block * 6 + k]).toBe(Math.min(...values));
        expect(blocks[block * 6 + 3 + k]).toBe(Math.max(...values));
      }
    }
  });
});

describe('points under the brush', () => {
  it('are those of every point, one by one', () => {
    const found = collect((take) => inCapsule(frame, [0.1, 0.1, 1], [0.3, 0.2, 1.1], 0.07, take));
    const [ax, ay, az] = [0.2, 0.1, 0.1];
    const expected = brute((x, y, z) => {
      const [px, py, pz] = [x - 0.1, y - 0.1, z - 1];
      const t = Math.min(
        1,
        Math.max(0, (px * ax + py * ay + pz * az) / (ax * ax + ay * ay + az * az)),
      );
      return Math.hypot(px - t * ax, py - t * ay, pz - t * az) <= 0.07;
    });
    expect(found.length).toBeGreaterThan(100);
    expect(found).toEqual(expected);
  });

  it('are on both walls when it reaches through', () => {
    const found = collect((take) => alongRay(frame, [0.2, 0.2, 0], forward, 0.035, take));
    expect(found).toEqual(brute((x, y) => Math.hypot(x - 0.2, y - 0.2) <= 0.035));
    expect(found.some((point) => point >= 1600)).toBe(true);
  });
});

it('finds no point of a hidden sensor', () => {
  const segment = segmentOf([wall(40, 1000), wall(40, 2000)]);
  const chunks = segment.chunks.map((chunk, sensor) => ({ ...chunk, sensor }));
  const frame = new CloudFrame(0, false);
  frame.add({ ...segment, chunks });
  const eye: Vec = [0.2, 0.2, 0];
  // All points project to where they are, and lie before the camera.
  const clip = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1];
  const square = [[0, 0], [0.4, 0], [0.4, 0.4], [0, 0.4]] as const; // prettier-ignore
  const ways = [
    (found: (point: number) => void) => alongRay(frame, eye, forward, 0.1, found),
    (found: (point: number) => void) => inCapsule(frame, eye, [0.2, 0.2, 2], 0.1, found),
    (found: (point: number) => void) => inBox(frame, [0.2, 0.2, 1.5], [0.2, 0.2, 2], [0, 0, 0, 1], found), // prettier-ignore
    (found: (point: number) => void) => insideOutline(frame, square, clip, found),
  ];
  const shown = ways.map(collect);
  hiddenSensors.value = new Set([0]);
  try {
    expect(firstHit(frame, eye, forward, 0.05)?.distance).toBeCloseTo(2, 3);
    ways.forEach((way, i) => {
      const rest = shown[i]!.filter((point) => point >= 1600);
      expect(rest.length).toBeLessThan(shown[i]!.length);
      expect(collect(way)).toEqual(rest);
    });
  } finally {
    hiddenSensors.value = new Set();
  }
});
