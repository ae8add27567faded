import { describe, expect, it } from 'vitest';
import type { TimelineRow } from '../../store/state';
import { cellKind, doubtfulFrames, nextUnlabelled } from '../../store/cells';
import { placeOf } from './draw';
import { reveal, runs, stretched, ticks, xToFrame, zoom } from './layout';

/** One character a frame: p painted, t tracked, ? doubtful, x lost, o occluded. */
function row(text: string): TimelineRow {
  const cells = [...text]; // eslint-disable-line @typescript-eslint/no-misused-spread -- ASCII
  const of = <T>(values: Record<string, T>, other: T): T[] =>
    cells.map((cell) => values[cell] ?? other);
  return {
    points: Uint32Array.from(of({ p: 9, t: 9, '?': 9, o: 0 }, 0)),
    painted: Uint32Array.from(of({ p: 9 }, 0)),
    confidence: Float32Array.from(of({ t: 0.9, '?': 0.2 }, NaN)),
    state: Uint8Array.from(of({ p: 1, t: 2, '?': 2, o: 3, x: 4 }, 0)),
  };
}

describe('strips', () => {
  it('say what each frame is', () => {
    const cells = row('.pt?ox');
    expect([0, 1, 2, 3, 4, 5].map((frame) => cellKind(cells, frame))).toEqual(
      ['none', 'painted', 'tracked', 'doubtful', 'occluded', 'lost']); // prettier-ignore
  });

  it('join equal frames', () => {
    expect(runs(row('pttt..tt'), { first: 0, length: 8 }, 8, 100)).toEqual([
      { from: 0, to: 1, kind: 'painted' },
      { from: 1, to: 4, kind: 'tracked', sure: 0.8 },
      { from: 6, to: 8, kind: 'tracked', sure: 0.8 },
    ]);
  });

  it('keep a single doubtful frame visible when many share a pixel', () => {
    const text = `${'t'.repeat(500)}?${'t'.repeat(499)}`;
    const found = runs(row(text), { first: 0, length: 1000 }, 1000, 100);
    expect(found.map((run) => run.kind)).toEqual(['tracked', 'doubtful', 'tracked']);
  });

  it('are shaded by confidence', () => {
    const cells = row('tttt');
    cells.confidence.set([1, 0.99, 0.61, 0.6]);
    const shades = runs(cells, { first: 0, length: 4 }, 4, 100).map(({ to, sure }) => [to, sure]);
    expect(shades).toEqual([[1, 1], [2, 0.8], [4, 0.6]]); // prettier-ignore
  });

  it('lead to the next frame without a label', () => {
    const rows = [row('pp..p.'), row('p.p.t.')];
    expect(nextUnlabelled(rows, 0, 6, 1)).toBe(3);
    expect(nextUnlabelled(rows, 3, 6, 1)).toBe(5);
    expect(nextUnlabelled(rows, 3, 6, -1)).toBe(5);
    expect(nextUnlabelled([row('pp')], 0, 2, 1)).toBeNull();
  });

  it('know which frames want a look', () => {
    expect(doubtfulFrames([row('t?.x'), row('t?tt')], 4)).toEqual([1, 3]);
  });
});

describe('the ruler', () => {
  it('numbers round frames with room between them', () => {
    const marks = ticks({ first: 0, length: 90 }, 900, 90).filter((mark) => mark.major);
    expect(marks.map((mark) => mark.frame).slice(0, 3)).toEqual([0, 10, 20]);
    const long = ticks({ first: 0, length: 20000 }, 900, 20000).filter((mark) => mark.major);
    expect(long.length).toBeLessThan(17);
  });

  it('finds the frame under a pixel, never outside of the recording', () => {
    const span = { first: 0, length: 10 };
    expect([-5, 0, 55, 99, 400].map((x) => xToFrame(x, span, 100, 10))).toEqual([0, 0, 5, 9, 9]);
  });

  it('zooms about the pixel under the mouse and stays inside', () => {
    const span = zoom({ first: 0, length: 100 }, 2, 50, 100, 100);
    expect(span).toEqual({ first: 25, length: 50 });
    expect(zoom(span, 0.1, 50, 100, 100)).toEqual({ first: 0, length: 100 });
    expect(zoom(span, 1e6, 0, 100, 100).length).toBe(8);
  });

  it('moves just far enough to show the playhead', () => {
    expect(reveal({ first: 10, length: 20 }, 15, 100).first).toBe(10);
    expect(reveal({ first: 10, length: 20 }, 30, 100).first).toBe(11);
    expect(reveal({ first: 10, length: 20 }, 2, 100).first).toBe(2);
  });
});

describe('a long recording', () => {
  it('shows a doubtful frame at least three pixels wide, in its place', () => {
    const span = { first: 0, length: 2000 };
    const [left, wide] = placeOf({ from: 1000, to: 1001, kind: 'doubtful' }, span, 1000);
    expect(wide).toBe(3);
    expect(left + wide / 2).toBeCloseTo(500.25);
    expect(placeOf({ from: 1000, to: 1001, kind: 'tracked' }, span, 1000)[1]).toBe(1);
  });

  it('is shown in part by the ends of a bar, which meet nowhere', () => {
    const span = { first: 100, length: 400 };
    expect(stretched(span, 50, 'first', 2000)).toEqual({ first: 150, length: 350 });
    expect(stretched(span, 900, 'first', 2000)).toEqual({ first: 492, length: 8 });
    expect(stretched(span, -50, 'last', 2000)).toEqual({ first: 100, length: 350 });
    expect(stretched(span, 9000, 'last', 2000)).toEqual({ first: 100, length: 1900 });
    expect(stretched(span, -100, 'both', 2000)).toEqual({ first: 200, length: 200 });
    expect(stretched(span, 2000, 'both', 2000)).toEqual({ first: 0, length: 2000 });
  });
});
