import { describe, expect, it } from 'vitest';
import {
  acceptances,
  assignmentsOf,
  type Finding,
  framesOf,
  type Overview,
  type Standing,
  standingOf,
  stepFrom,
  worstFrames,
  progressOf,
} from './model';

function finding(id: string, first: number | null, labels: number[] = [1]): Finding {
  return { id, kind: 'few', text: '', labels, first, last: first, place: null, settled: false };
}

function standing(first: number, last: number, more: Partial<Standing> = {}): Standing {
  return {
    first, last, label: null, state: 'open', note: '', place: null, assignee: '', by: '', at: null,
    changed: false, ...more,
  }; // prettier-ignore
}

const overview = (...frames: Standing[]): Overview => ({
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
  const told = overview(standing(0, 9, { label: 2 }), standing(4, 6, { state: 'rejected' }));
  expect(standingOf(told, 5)?.state).toBe('rejected');
  expect(standingOf(told, 7)).toBeNull();
});

it('joins what one person was given across states', () => {
  const told = overview(
    standing(0, 2, { assignee: 'ada', state: 'accepted' }),
    standing(3, 5, { assignee: 'ada' }),
    standing(6, 7, { assignee: 'grace' }),
    standing(8, 8),
  );
  expect(assignmentsOf(told).map(({ assignee, first, last }) => [assignee, first, last])).toEqual([
    ['ada', 0, 5],
    ['grace', 6, 7],
  ]);
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
  const found = worstFrames({ miou: 1, same: 1, labels: [], frames });
  expect(found.map(({ frame }) => frame)).toEqual([1, 0]);
});

it('tells of each label who answers for its frames, the most doubtful first', () => {
  const row = (points: number[], painted: number[], confidence: number[], states: number[]) => ({
    points: Uint32Array.from(points),
    painted: Uint32Array.from(painted),
    confidence: Float32Array.from(confidence),
    state: Uint8Array.from(states),
  });
  const none = [0, 0, 0, 0, 0];
  const rows = new Map([
    [1, row([9, 9, 9, 0, 0], [9, 0, 0, 0, 0], [NaN, 0.9, 0.9, NaN, NaN], none)],
    [2, row(none, none, none, none)],
    [3, row([9, 9, 9, 0, 0], none, [0.9, 0.2, 0.9, 0, 0], [2, 2, 2, 3, 4])],
  ]);
  expect(progressOf(rows)).toEqual([
    { label: 3, painted: 0, tracked: 3, doubtful: 2 },
    { label: 1, painted: 1, tracked: 2, doubtful: 0 },
  ]);
});
