import { describe, expect, it } from 'vitest';
import type { LabelUpdate } from '../../net/wire';
import { CloudFrame, pointsWithin } from './frame';
import { DELETED } from './piece';
import { FrameStore } from './store';
import { frameOf, segmentOf, wall } from './testing';

function update(fields: Partial<LabelUpdate>, lengths: number[], values: number[]): LabelUpdate {
  return {
    sequence: 's',
    frame: 0,
    revision: 1,
    base: 0,
    edit: null,
    provisional: false,
    first: 0,
    count: 0,
    lengths: Uint32Array.from(lengths),
    values: Uint16Array.from(values),
    ...fields,
  };
}

function labels(frame: CloudFrame): number[] {
  return Array.from({ length: frame.loaded }, (_, i) => frame.labelOf(i));
}

describe('labels of a frame', () => {
  it('takes whole values that come before the points, and deltas in between', () => {
    const frame = new CloudFrame(0, false);
    frame.applyLabels(update({ base: null, count: 8 }, [3, 5], [7, 0]));
    frame.applyLabels(update({}, [1, 6], [9]));
    frame.add(segmentOf([wall(2, 0)], { total: 8, final: false }));
    frame.add(segmentOf([wall(2, 0)], { from: 4, total: 8 }));
    expect(frame.complete).toBe(true);
    expect(labels(frame)).toEqual([7, 9, 7, 0, 0, 0, 9, 0]);
  });

  it('applies a delta across pieces, one value each or one for all', () => {
    const frame = frameOf(wall(2, 0), wall(2, 0));
    frame.applyLabels(update({}, [0, 3, 4, 7], [1, 2, 3, DELETED]));
    expect(labels(frame)).toEqual([1, 0, 0, 2, 3, 0, 0, DELETED]);
    frame.applyLabels(update({}, [3, 4], [5]));
    expect(labels(frame)).toEqual([1, 0, 0, 5, 5, 0, 0, DELETED]);
  });

  it('shows what is predicted where there is no label, and nowhere else', () => {
    const frame = frameOf(wall(2, 0));
    frame.applyLabels(update({}, [1], [9]));
    frame.setOverlay('stroke', { indices: Uint32Array.of(2), values: Uint16Array.of(4) });
    frame.predict({ numbers: null, ids: Uint16Array.of(65024, 65024, 65024, 0) });
    const shown = new Uint16Array(4);
    frame.gatherShown(shown);
    expect([...shown]).toEqual([65024, 9, 4, 0]);
    expect(labels(frame)).toEqual([0, 9, 4, 0]);
    frame.predict({ numbers: Uint32Array.of(0, 1, 3), ids: Uint16Array.of(65025, 65025, 65026) });
    frame.gatherShown(shown);
    expect([...shown]).toEqual([65025, 9, 4, 65026]);
    const page = new Uint16Array(2);
    frame.fillPredicted(page, 2, 2);
    expect([...page]).toEqual([0, 65026]);
  });

  it('merges overlays in any order, the newest value first', () => {
    const frame = frameOf([[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]]); // prettier-ignore
    frame.mergeOverlay('run', Uint32Array.of(3, 1), Uint16Array.of(7, 5));
    frame.mergeOverlay('run', Uint32Array.of(2, 0, 3), Uint16Array.of(9));
    expect([...frame.overlays.get('run')!.indices]).toEqual([0, 1, 2, 3]);
    expect([...frame.overlays.get('run')!.values]).toEqual([9, 5, 9, 9]);
  });

  it('shows overlays over the values of the server until they are dropped', () => {
    const frame = frameOf(wall(2, 0));
    frame.setOverlay('stroke', { indices: Uint32Array.of(1, 2), values: Uint16Array.of(4) });
    frame.mergeOverlay('run', Uint32Array.of(2, 3), Uint16Array.of(5, 6));
    frame.mergeOverlay('run', Uint32Array.of(0), Uint16Array.of(8));
    expect(labels(frame)).toEqual([8, 4, 5, 6]);
    expect(frame.storedLabelOf(1)).toBe(0);
    frame.dropOverlay('run');
    expect(labels(frame)).toEqual([0, 4, 4, 0]);
  });
});

describe('points of a frame', () => {
  it('grow as a prefix; repeats and gaps are not used', () => {
    const frame = new CloudFrame(0, false);
    const first = segmentOf([wall(2, 0)], { total: 12, final: false });
    expect(frame.add(first)).toBe(true);
    expect(frame.add(first)).toBe(false);
    expect(frame.add(segmentOf([wall(2, 0)], { from: 8, total: 12 }))).toBe(false);
    expect(frame.loaded).toBe(4);
    expect(frame.complete).toBe(false);
  });

  it('of a large frame come and go by chunk', () => {
    const frame = new CloudFrame(0, true);
    frame.add(segmentOf([wall(2, 0)], { from: 100, total: 1000, final: false }));
    frame.add(segmentOf([wall(2, 0)], { from: 20, total: 1000, final: false }));
    frame.applyLabels(update({}, [21, 50, 101], [3]));
    expect(frame.pieces.map((piece) => piece.first)).toEqual([20, 100]);
    expect([frame.labelOf(21), frame.labelOf(50), frame.labelOf(101)]).toEqual([3, 0, 3]);
    frame.remove(20);
    expect(frame.loaded).toBe(4);
    expect(frame.pieceOf(21)).toBeNull();
  });
});

describe('the cache of frames', () => {
  const size = segmentOf([wall(4, 0)]).vertices.byteLength;

  function filled(budget: number): FrameStore {
    const store = new FrameStore(10, false, budget);
    for (const frame of [0, 1, 2, 3, 8, 9]) store.add(segmentOf([wall(4, 0)], { frame }));
    return store;
  }

  it('drops what playing reaches last, and never the frame on screen', () => {
    const store = filled(3 * size);
    const dropped = store.evict({ frame: 2, direction: 1 }, [1]).map((frame) => frame.index);
    // From 2 forward: 3, 8, 9, 0, (1, on screen).
    expect(dropped).toEqual([0, 9, 8]);
    expect(store.usedBytes).toBe(3 * size);
  });

  it('keeps the other side when playing backward', () => {
    const dropped = filled(3 * size).evict({ frame: 2, direction: -1 }, []);
    expect(dropped.map((frame) => frame.index)).toEqual([3, 8, 9]);
  });

  it('finds the newest frame at or before the clock', () => {
    const store = filled(Infinity);
    expect(store.newest(6, 1, true)).toBe(3);
    expect(store.newest(6, -1, true)).toBe(8);
    const sparse = new FrameStore(10, false, Infinity);
    sparse.add(segmentOf([wall(4, 0)], { frame: 8 }));
    expect(sparse.newest(2, 1, true)).toBe(8);
    expect(sparse.newest(2, 1, false)).toBe(-1);
  });

  it('tells which frames are here', () => {
    const store = filled(Infinity);
    store.add(segmentOf([wall(4, 0)], { frame: 4, total: 99, final: false }));
    expect(store.ranges()).toEqual([
      { first: 0, last: 3, complete: true },
      { first: 4, last: 4, complete: false },
      { first: 8, last: 9, complete: true },
    ]);
  });
});

describe('a frame of which not all is drawn', () => {
  it('shows whole levels, the first one always', () => {
    const frame = frameOf(wall(2, 0), wall(3, 1), wall(4, 2));
    const within = [0, 4, 12, 13, 28, 29, Infinity].map((limit) => pointsWithin(frame, limit));
    expect(within).toEqual([4, 4, 4, 13, 13, 29, 29]);
  });
});

describe('chunks of a large frame', () => {
  it('give back their memory when they are dropped, together with what came with them', () => {
    const store = new FrameStore(1, true, Infinity);
    store.add(segmentOf([wall(2, 0), wall(2, 5)], { total: 12, final: false }));
    store.add(segmentOf([wall(2, 9)], { from: 8, total: 12, final: false }));
    const frame = store.get(0)!;
    const used = store.usedBytes;
    expect(store.dropChunks(frame, [0])).toEqual([]);
    expect(frame.loaded).toBe(8);
    const [buffer] = store.dropChunks(frame, [1, 99]);
    expect(store.usedBytes).toBe(used - buffer!.byteLength);
    expect(frame.pieces.map((piece) => piece.index)).toEqual([8]);
    // Dropped chunks may come again.
    expect(store.add(segmentOf([wall(2, 0)], { total: 12, final: false }))).toBe(true);
    expect(frame.loaded).toBe(8);
  });
});
