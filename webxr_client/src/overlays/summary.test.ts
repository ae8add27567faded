import { Matrix4 } from 'three';
import { describe, expect, it } from 'vitest';
import { type CloudFrame } from '../cloud/points/frame';
import { DELETED } from '../cloud/points/piece';
import { frameOf } from '../cloud/points/testing';
import { at, BOX, HALF, MIDDLE, Summaries, type Summary } from './summary';

type Vector = [number, number, number];
const ROOM = new Matrix4().makeTranslation(10, 0, -5);

/** A bar of points, millimetres: `long` along a direction in the floor, `high`, `wide`. */
function bar(angle: number, long: number, high: number, wide: number): Vector[] {
  const points: Vector[] = [];
  for (let u = -long; u <= long; u += long / 10) {
    for (let v = -wide; v <= wide; v += wide) {
      for (let y = 0; y <= high; y += high / 2) {
        points.push([
          Math.round(1000 + Math.cos(angle) * u - Math.sin(angle) * v),
          y,
          Math.round(1000 + Math.sin(angle) * u + Math.cos(angle) * v),
        ]);
      }
    }
  }
  return points;
}

function labelled(points: Vector[], labels: (i: number) => number): CloudFrame {
  const frame = frameOf(points);
  const piece = frame.pieces[0]!;
  piece.labels = Uint16Array.from({ length: piece.count }, (_, i) => labels(i));
  return frame;
}

function triple({ values }: Summary, slot: number, field: number): number[] {
  return [0, 1, 2].map((k) => values[at(slot, field + k)]!);
}

describe('where a label is', () => {
  it.each([0, 0.4, 1.2, 2.7])('is an upright box along its points, turned by %f', (angle) => {
    const frame = labelled(bar(angle, 400, 200, 50), () => 7);
    const summary = new Summaries().of(frame, ROOM, 0);
    expect(summary.labels).toEqual([7]);
    const [x, y, z] = triple(summary, 0, BOX);
    expect(x).toBeCloseTo(11, 2);
    expect(y).toBeCloseTo(0.1, 2);
    expect(z).toBeCloseTo(-4, 2);
    const [u, up, v] = triple(summary, 0, HALF);
    expect(u).toBeCloseTo(0.4, 2);
    expect(up).toBeCloseTo(0.1, 2);
    expect(v).toBeCloseTo(0.05, 2);
    // The long axis of the box lies along the bar, either way round.
    const axis = [Math.cos(summary.yaw[0]!), -Math.sin(summary.yaw[0]!)] as const;
    const along = axis[0] * Math.cos(angle) + axis[1] * Math.sin(angle);
    expect(Math.abs(along)).toBeGreaterThan(0.999);
  });

  it('leaves out what is unlabeled or deleted, and tells labels apart', () => {
    const points: Vector[] = [[0, 0, 0], [100, 0, 0], [200, 0, 0], [300, 0, 0], [9000, 0, 0]]; // prettier-ignore
    const labels = [3, 5, 3, 0, DELETED];
    const summary = new Summaries().of(
      labelled(points, (i) => labels[i]!),
      ROOM,
      0,
    );
    expect(summary.labels).toEqual([3, 5]);
    expect(summary.count).toEqual([2, 1]);
    expect(triple(summary, summary.of(3), MIDDLE)[0]).toBeCloseTo(10.1, 5);
    expect(triple(summary, summary.of(5), MIDDLE)[0]).toBeCloseTo(10.1, 5);
    expect(summary.of(9)).toBe(-1);
  });

  it('counts a stroke that the server has not answered yet', () => {
    const frame = labelled([[0, 0, 0], [100, 0, 0]], () => 0); // prettier-ignore
    frame.setOverlay('stroke', { indices: Uint32Array.of(1), values: Uint16Array.of(4) });
    expect(new Summaries().of(frame, ROOM, 0).labels).toEqual([4]);
  });

  it('is found anew when labels change, but not in every picture while one paints', () => {
    const summaries = new Summaries();
    const frame = labelled([[0, 0, 0], [100, 0, 0]], () => 1); // prettier-ignore
    expect(summaries.of(frame, ROOM, 0).count).toEqual([2]);
    frame.setOverlay('stroke', { indices: Uint32Array.of(1), values: Uint16Array.of(4) });
    expect(summaries.of(frame, ROOM, 10).labels).toEqual([1]);
    expect(summaries.stale(frame)).toBe(true);
    expect(summaries.of(frame, ROOM, 1000).labels).toEqual([1, 4]);
    expect(summaries.stale(frame)).toBe(false);
  });
});
