import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { Pairing } from './pairing';
import type { Segment } from './chunk/segment';
import type { FromWorker, LabelUpdate } from './wire';

function labels(frame: number, revision: number): LabelUpdate {
  return {
    sequence: 's',
    frame,
    revision,
    base: null,
    edit: null,
    provisional: false,
    first: 0,
    count: 0,
    lengths: new Uint32Array(),
    values: new Uint16Array(),
  };
}

function points(frame: number): Segment {
  return { frame, vertices: new ArrayBuffer(12), images: [] as Segment['images'] } as Segment;
}

describe('labels ahead of points', () => {
  let posted: FromWorker[] = [];
  let pairing: Pairing;
  beforeEach(() => {
    vi.useFakeTimers();
    posted = [];
    pairing = new Pairing((message) => posted.push(message));
  });
  afterEach(() => {
    vi.useRealTimers();
  });

  it('go with the points of their frame', () => {
    pairing.hold(labels(3, 1));
    pairing.segment(points(3));
    expect(posted).toMatchObject([{ t: 'segment', labels: { frame: 3 } }]);
    vi.runAllTimers();
    expect(posted).toHaveLength(1);
  });

  it('go ahead of whatever else comes, in order', () => {
    pairing.hold(labels(3, 1));
    pairing.hold(labels(3, 2));
    pairing.segment(points(4));
    pairing.hold(labels(5, 3));
    pairing.flush();
    expect(posted).toMatchObject([
      { t: 'labels', update: { revision: 1 } },
      { t: 'labels', update: { revision: 2 } },
      { t: 'segment', labels: null },
      { t: 'labels', update: { revision: 3 } },
    ]);
  });

  it('do not wait for points that never come', () => {
    pairing.hold(labels(3, 1));
    expect(posted).toEqual([]);
    vi.runAllTimers();
    expect(posted).toMatchObject([{ t: 'labels', update: { revision: 1 } }]);
  });
});
