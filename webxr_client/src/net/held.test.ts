import { describe, expect, it } from 'vitest';
import type { Annotation, Frame } from '../protocol/messages';
import { HeldFrames } from './held';

const nothing = new Uint8Array();

function points(frame: number, first: number, count: number): Frame {
  const chunks = Array.from({ length: count }, (_, index) => ({ index: first + index }));
  return {
    type: 'frame',
    sequence: 's',
    frame,
    total: 9,
    final: false,
    chunks,
    data: nothing,
  } as unknown as Frame;
}

function values(frame: number, revision: number, base: number | null): Annotation {
  return {
    type: 'annotation',
    sequence: 's',
    frame,
    revision,
    base,
    edit: null,
    author: null,
    provisional: false,
    first: 0,
    count: 0,
    lengths: nothing,
    values: nothing,
  };
}

describe('what the page holds', () => {
  it('is listed with the chunks that join on', () => {
    const held = new HeldFrames();
    for (const frame of [3, 5]) {
      held.values(values(frame, 1, null));
      held.points(points(frame, 0, 2));
    }
    held.points(points(3, 2, 4));
    held.points(points(5, 9, 1));
    expect(held.list()).toEqual([
      [3, 6],
      [5, 2],
    ]);
    held.forget([3]);
    expect(held.list()).toEqual([[5, 2]]);
  });

  it('misses a delta of one frame, whatever came of another', () => {
    const held = new HeldFrames();
    held.values(values(0, 4, null));
    held.values(values(1, 7, null));
    expect(held.values(values(0, 8, 4))).toBe(true);
    expect(held.values(values(1, 9, 7))).toBe(true);
    expect(held.values(values(0, 12, 10))).toBe(false);
    expect(held.values(values(0, 10, 8))).toBe(true);
    // Of a frame that is not here nothing can be missed.
    expect(held.values(values(2, 12, 11))).toBe(true);
  });

  it('misses nothing that the answer to a resumed connection announces', () => {
    const held = new HeldFrames();
    held.values(values(0, 3, null));
    held.values(values(1, 8, null));
    held.resumed(8);
    // Edits 4 to 8 were of other frames: the server's delta builds on the announced revision.
    expect(held.values(values(0, 9, 7))).toBe(true);
    expect(held.values(values(1, 12, 11))).toBe(false);
  });
});
