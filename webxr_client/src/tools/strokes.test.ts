import { describe, expect, it, vi } from 'vitest';
import { DELETED } from '../cloud/points/piece';
import { Matrix4 } from 'three';
import { firstHitAmong, layersOf, type Layer, type PlacedFrame } from '../cloud/points/layer';
import { frameOf, wall } from '../cloud/points/testing';
import { runsOf } from '../protocol/codec';
import { state } from '../store/state';
import type { Brush, ClientMessage, StrokeResult } from '../protocol/messages';
import { Strokes } from './strokes';

const ray: Brush = { label: 2, tool: 'paint', shape: 'ray', radius: 0.025 };

const seen = (label: number): boolean => label !== DELETED;

function setUp(
  locked: (label: number) => boolean = () => false,
  look: { seen: (label: number) => boolean; hidden: number[] } = { seen, hidden: [] },
  layers: readonly Layer[] = [],
) {
  const frame = frameOf(wall(40, 1000));
  const sent: ClientMessage[] = [];
  // Messages to the worker are copied.
  const send = (message: ClientMessage): void => void sent.push(structuredClone(message));
  const hidden = (): number[] => look.hidden;
  const deps = {
    send,
    locked,
    seen: look.seen,
    hidden,
    layers: () => layers,
    changed: vi.fn(),
    now: () => 0,
  };
  return { frame, sent, strokes: new Strokes(deps) };
}

function painted(frame: ReturnType<typeof frameOf>, label: number): number {
  return Array.from({ length: frame.loaded }, (_, i) => frame.labelOf(i)).filter((l) => l === label)
    .length;
}

function result(id: string, fields: Partial<StrokeResult>): StrokeResult {
  return { type: 'stroke_result', id, frame: 0, touched: 1, changed: 1, edit: id, revision: 1, final: true, ...fields }; // prettier-ignore
}

const at = { origin: [0.2, 0.2, 0], direction: [0, 0, 1] } as const;

describe('a stroke', () => {
  it('shows at once what it will paint, and sends source coordinates in batches', () => {
    const { frame, sent, strokes } = setUp();
    const stroke = strokes.begin(frame, ray, [100, 0, 0]);
    stroke.add(at);
    stroke.add(at);
    expect(strokes.show()).toBe(true);
    strokes.send();
    expect(strokes.show()).toBe(false);
    expect(painted(frame, 2)).toBe(21);
    stroke.end();
    expect(sent.map((message) => message.type)).toEqual([
      'stroke_begin',
      'stroke_samples',
      'stroke_end',
    ]);
    expect(sent[1]).toMatchObject({ samples: [{ origin: [100.2, 0.2, 0] }, {}] });
  });

  it('paints what is laid over the frame as well, where it lies', () => {
    const over = frameOf(wall(40, 1000));
    // A metre to the right of where it is by itself.
    const placement = new Matrix4().makeTranslation(1, 0, 0);
    const placed: PlacedFrame = {
      frame: over,
      placed: placement,
      moving: new Map([[7, new Matrix4()]]),
    };
    over.setOverlay('old', { indices: Uint32Array.of(0, 1), values: Uint16Array.of(7) });
    const { frame, strokes } = setUp(undefined, undefined, layersOf(placed));
    const stroke = strokes.begin(frame, { ...ray, radius: 0.05 }, [0, 0, 0]);
    // Only the other frame is there, 10 points to the right of its corner.
    stroke.add({ origin: [1.1, 0.1, 0], direction: [0, 0, 1] });
    strokes.show();
    expect(painted(frame, 2)).toBe(0);
    const before = painted(over, 2);
    expect(before).toBeGreaterThan(60);
    stroke.end();
    strokes.drop(stroke.id);
    expect(painted(over, 2)).toBe(0);
    // The two points of a label that moved by itself lie at the shown frame's own corner.
    const hit = firstHitAmong(frame, layersOf(placed), [-0.02, 0, 0], [0, 0, 1], 0.03, () => true);
    expect(hit?.position).toEqual([-0.02, 0, 1]);
  });

  it('keeps its preview until the delta has come', () => {
    const { frame, strokes } = setUp();
    const stroke = strokes.begin(frame, ray, [0, 0, 0]);
    stroke.add(at);
    stroke.end();
    strokes.onResult(result(stroke.id, { final: false }));
    strokes.onResult(result(stroke.id, {}));
    expect(painted(frame, 2)).toBe(21);
    strokes.drop(stroke.id);
    expect(painted(frame, 2)).toBe(0);
  });

  it('says which points it takes when all are here, and leaves it to the server otherwise', () => {
    for (const complete of [true, false]) {
      const { frame, sent, strokes } = setUp();
      frame.complete = complete;
      const stroke = strokes.begin(frame, ray, [0, 0, 0]);
      stroke.add(at);
      strokes.show();
      const shown = [...frame.overlays.values()][0]!.indices;
      stroke.end();
      const touched = complete ? [{ frame: 0, runs: runsOf(shown) }] : null;
      expect(sent.at(-1)).toMatchObject({ type: 'stroke_end', touched });
    }
  });

  it('finds what the strokes before it leave, but not what it does itself', () => {
    const near = wall(40, 500);
    const frame = frameOf([...near, ...wall(40, 1000)]);
    const { strokes } = setUp();
    const digging = strokes.begin(frame, { ...ray, tool: 'delete' }, [0, 0, 0]);
    for (let i = 0; i < 2; i++) {
      digging.add(at);
      strokes.show();
    }
    expect(painted(frame, DELETED)).toBe(21);
    digging.end();
    const second = strokes.begin(frame, { ...ray, only_unlabeled: true }, [0, 0, 0]);
    second.add(at);
    second.end();
    const third = strokes.begin(frame, { ...ray, label: 3, only_unlabeled: true }, [0, 0, 0]);
    third.add(at);
    third.end();
    expect([painted(frame, 2), painted(frame, 3)]).toEqual([21, 0]);
  });

  it('says when fewer points changed than it showed', () => {
    for (const changed of [21, 20]) {
      const { frame, strokes } = setUp();
      state.notices.value = [];
      const stroke = strokes.begin(frame, ray, [0, 0, 0]);
      stroke.add(at);
      stroke.end();
      strokes.drop(stroke.id);
      strokes.onResult(result(stroke.id, { changed }));
      const titles = state.notices.value.map(({ title }) => title);
      expect(titles).toEqual(changed < 21 ? ['20 of 21 points changed'] : []);
    }
  });

  it('takes the preview away at once when nothing changed', () => {
    const { frame, strokes } = setUp();
    const stroke = strokes.begin(frame, ray, [0, 0, 0]);
    stroke.add(at);
    stroke.end();
    strokes.onResult(result(stroke.id, { changed: 0 }));
    expect(painted(frame, 2)).toBe(0);
  });

  it('shows and sends nothing more once the server has refused it', () => {
    const { frame, sent, strokes } = setUp();
    const stroke = strokes.begin(frame, ray, [0, 0, 0]);
    stroke.add(at);
    strokes.show();
    strokes.drop(stroke.id);
    expect(painted(frame, 2)).toBe(0);
    const before = sent.length;
    stroke.add(at);
    stroke.end();
    expect(painted(frame, 2)).toBe(0);
    expect(sent).toHaveLength(before);
  });

  it('that is given up leaves nothing, and tells the server so', () => {
    const { frame, sent, strokes } = setUp();
    const stroke = strokes.begin(frame, ray, [0, 0, 0]);
    stroke.add(at);
    strokes.show();
    stroke.cancel();
    stroke.end();
    expect(painted(frame, 2)).toBe(0);
    expect(sent.map((message) => message.type)).toEqual(['stroke_begin', 'stroke_cancel']);
  });

  it('spares locked labels, and labelled points when only unlabelled ones are asked for', () => {
    for (const [brush, locked] of [
      [ray, (label: number) => label === 1],
      [{ ...ray, only_unlabeled: true }, () => false],
    ] as const) {
      const { frame, strokes } = setUp(locked);
      frame.pieces[0]!.labels = new Uint16Array(1600).fill(1, 0, 820);
      const stroke = strokes.begin(frame, brush, [0, 0, 0]);
      stroke.add(at);
      strokes.show();
      expect(painted(frame, 1)).toBe(820);
      expect(painted(frame, 2)).toBeGreaterThan(5);
    }
  });

  it('leaves hidden points alone, looks through them, and says which labels are hidden here', () => {
    const near = wall(40, 500);
    const frame = frameOf([...near, ...wall(40, 1000)]);
    const look = { seen: (label: number) => label !== 1 && label !== DELETED, hidden: [1] };
    const { sent, strokes } = setUp(undefined, look);
    frame.pieces[0]!.labels = new Uint16Array(2 * near.length).fill(1, 0, near.length);
    strokes.begin(frame, ray, [0, 0, 0]).add(at);
    strokes.show();
    expect(painted(frame, 1)).toBe(near.length);
    expect(painted(frame, 2)).toBe(21);
    expect(sent[0]).toMatchObject({ brush: { hidden: [1] } });
  });

  it('deletes only unlabelled points when that is asked for', () => {
    const { frame, strokes } = setUp();
    frame.pieces[0]!.labels = new Uint16Array(1600).fill(1, 0, 820);
    const stroke = strokes.begin(
      frame,
      { ...ray, tool: 'delete', only_unlabeled: true },
      [0, 0, 0],
    );
    stroke.add(at);
    strokes.show();
    expect(painted(frame, 1)).toBe(820);
    expect(painted(frame, DELETED)).toBeGreaterThan(5);
  });

  it('shows at once what an outline or a box takes, in source coordinates', () => {
    const matrix = [5, 0, 0, -501, 0, 5, 0, -1, 0, 0, 1, 0, 0, 0, 0, 1];
    const polygon: [number, number][] = [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]]; // prettier-ignore
    const outline: Brush = { label: 2, tool: 'paint', shape: 'lasso', polygon, matrix };
    const box: Brush = { ...outline, shape: 'box', center: [100.2, 0.2, 1], size: [0.09, 0.09, 1] };
    for (const brush of [outline, box]) {
      const { frame, strokes } = setUp();
      strokes.begin(frame, brush, [100, 0, 0]);
      strokes.show();
      expect(painted(frame, 2)).toBe(81);
    }
  });

  it('deletes, and restores only what was deleted', () => {
    const { frame, strokes } = setUp();
    const stroke = strokes.begin(frame, { ...ray, tool: 'delete' }, [0, 0, 0]);
    stroke.add(at);
    strokes.show();
    expect(painted(frame, DELETED)).toBe(21);
  });
});
