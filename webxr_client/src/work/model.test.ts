import type { Finding, ReviewOverview, Standing } from '../protocol/values';
import { describe, expect, it } from 'vitest';
import { acceptances, framesOf, standingOf, stepFrom, worstFrames } from './model';

function finding(id: string, first: number | null, labels: number[] = [1]): Finding {
  return { id, kind: 'few', text: '', labels, first, last: first, place: null, settled: false };
}

function standing(first: number, last: number, more: Partial<Standing> = {}): Standing {
  return {
    first, last, label: null, state: 'open', note: '', place: null, assignee: '', by: '', at: null,
    changed: false, ...more,
  }; // prettier-ignore
}

const overview = (...frames: Standing[]): ReviewOverview => ({
  counts: { open: 0, review: 0, accepted: 0, rejected: 0 },
  frames,
  labels: [],
  people: [],
});

describe('stepping through findings', () => {
  const list = [finding('a', null), finding('b', 3), finding('c', 9)];

  it('leads from one to the next and round the end', () => {
    expect(stepFrom(list, 'b', 0, 1)?.id).toBe('c');
    expect(stepFrom(list, 'c', 0, 1)?.id).toBe('a');
    expect(stepFrom(list, 'a', 0, -1)?.id).toBe('c');
    expect(stepFrom([], 'a', 0, 1)).toBeNull();
  });

  it('goes on from the frame on screen when the one before has been mended', () => {
    expect(stepFrom(list, 'gone', 4, 1)?.id).toBe('c');
    expect(stepFrom(list, 'gone', 4, -1)?.id).toBe('b');
    expect(stepFrom(list, null, 20, 1)?.id).toBe('a');
  });
});

it('says frames in words', () => {
  expect(framesOf({ first: null, last: null })).toBe('palette');
  expect(framesOf({ first: 3, last: 3 })).toBe('frame 3');
  expect(framesOf({ first: 3, last: 8 })).toBe('frames 3–8');
});

it('finds how a frame stands, not a label in it', () => {
  const loaded = overview(standing(0, 9, { label: 2 }), standing(4, 6, { state: 'rejected' }));
  expect(standingOf(loaded, 5)?.state).toBe('rejected');
  expect(standingOf(loaded, 7)).toBeNull();
});

it('accepts each label of a finding, or its frames', () => {
  expect(acceptances(finding('a', 3, [1, 2]))).toEqual([
    { first: 3, last: 3, label: 1, state: 'accepted' },
    { first: 3, last: 3, label: 2, state: 'accepted' },
  ]);
  expect(acceptances(finding('a', null, [1]))).toEqual([{ label: 1, state: 'accepted' }]);
  expect(acceptances(finding('a', 3, []))).toEqual([{ first: 3, last: 3, state: 'accepted' }]);
});

it('names the frames that differ most', () => {
  const frames = [
    { frame: 0, labelled: 100, differ: 10 },
    { frame: 1, labelled: 10, differ: 5 },
    { frame: 2, labelled: 10, differ: 0 },
  ];
  const found = worstFrames({ miou: 1, same: 1, labels: [], frames, boxes: null });
  expect(found.map(({ frame }) => frame)).toEqual([1, 0]);
});
