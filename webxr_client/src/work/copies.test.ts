import { beforeEach, expect, test, vi } from 'vitest';
import { projects } from '../engine/recordings/projects';
import type { SequenceInfo } from '../protocol/messages';
import type { Disagreement, ProjectInfo, Task } from '../protocol/values';
import { bindActions } from '../store/actions';
import { state, type SequenceSummary } from '../store/state';
import { follow } from '../store/watch';
import {
  choose,
  chosenPair,
  current,
  followCopies,
  grouped,
  groups,
  type Pair,
  pair,
  pairs,
  personOf,
  shows,
  take,
  visitGroup,
  wordsOf,
} from './copies';
import { coloursOf, idsOf, labelsOf } from './shown-copies';
import { arrive, marked } from './places';
import { tasks } from './queue';
import { openWork } from './store';

const place = (frame: number, more: Partial<Disagreement> = {}): Disagreement => ({
  kind: 'missed', frame, first: ['car 1'], second: [], labels: [[1], []], points: 10,
  place: [frame, 0, 0], has: null, ...more,
}); // prettier-ignore
const seek = vi.fn();
const openSequence = vi.fn();
const calls: [string, unknown][] = [];
let answer: Pair[] = [];

beforeEach(() => {
  calls.length = 0;
  vi.stubGlobal('document', { baseURI: 'http://host/', hidden: false });
  vi.stubGlobal('fetch', (url: string, { method, body }: RequestInit) => {
    const path = url.replace('http://host/api/v1/projects/night/', '');
    calls.push([`${method} ${path}`, body ? JSON.parse(body as string) : undefined]);
    return Promise.resolve(Response.json(path.startsWith('agreement') ? answer : []));
  });
  bindActions({ time: { seek }, recordings: { openSequence } });
  projects.value = [{ id: 'night', role: 'reviewer' } as ProjectInfo];
  state.sequences.value = [{ id: 'room', project: 'night' } as SequenceSummary];
  state.copies.value = ['room-2', 'room-3'].map((id) => ({ id, project: 'night', copy_of: 'room' }) as SequenceSummary); // prettier-ignore
  state.sequence.value = { id: 'room-2' } as SequenceInfo;
  state.framed.value = true;
  tasks.value = [{ sequence: 'room-2', assignee: 'ada' } as Task];
  answer = [{ first: 'room-2', second: 'room-3', agreement: { miou: 1, same: 1, labels: [], frames: [], boxes: null }, places: [place(4), place(2, { points: 30, has: 0 })] }]; // prettier-ignore
  pairs.value = answer;
  chosenPair.value = '';
});

test('what differs alike in several frames is one entry, the most points first', () => {
  const renamed = place(0, { kind: 'renamed', labels: [[1], [2]], points: 99 });
  const found = grouped([place(4, { has: 1 }), renamed, place(2, { points: 30, has: 1 })]);
  expect(found.map(({ places }) => places.map(({ frame }) => frame))).toEqual([[0], [2, 4]]);
  expect(found[1]).toMatchObject({ points: 40, has: 1 });
  expect(groups.value[0]!.has).toBe(null);
});

test('people are called by their names, and one who has not begun by nobody’s', () => {
  const names = [personOf('room-2'), personOf('room-3')] as const;
  expect(names).toEqual(['ada', 'unassigned']);
  expect(wordsOf(place(0), names)).toBe('car 1: only ada has it');
});

test('a place is flown to in the recording, though a copy is open', async () => {
  const stop = follow(arrive);
  visitGroup(groups.value[0]!);
  expect(openSequence).toHaveBeenCalledWith('room');
  expect(current.value?.frame).toBe(2);
  state.sequence.value = { id: 'room' } as SequenceInfo;
  await Promise.resolve();
  expect(seek).toHaveBeenCalledWith(2);
  expect(marked.value).toEqual([2, 0, 0]);
  stop();
});

test('one’s labels are taken at the places of an entry alone, and people compared anew', async () => {
  await take('room-3', groups.value[0]);
  expect(calls.map(([call]) => call)).toEqual(['POST merge', 'GET agreement?sequence=room', 'GET scores']); // prettier-ignore
  expect(calls[0]![1]).toMatchObject({
    sequence: 'room',
    take: 'room-3',
    region: { labels: { 'room-2': [1], 'room-3': [] }, frame: null },
  });
});

test('the tab compares once it is open, and shows the recording again when it is left', async () => {
  const stop = followCopies();
  expect(calls).toEqual([]);
  openWork('agreement');
  expect(calls.map(([call]) => call)).toEqual(['GET agreement?sequence=room']);
  await vi.waitFor(() => expect(pairs.value).toEqual(answer));
  shows.value = 'first';
  openWork('tasks');
  expect(shows.value).toBe('recording');
  stop();
});

test('another import of the same points is compared with the recording', async () => {
  const row = { project: 'night', frames: 9, damaged: null };
  state.sequences.value = [{ id: 'room', name: 'Room', ...row }, { id: 'hall', name: 'Hall', ...row }] as SequenceSummary[]; // prettier-ignore
  await choose('room/hall');
  expect(calls.map(([call]) => call)).toEqual(['GET http://host/api/v1/sequences/room/agreement?with=hall']); // prettier-ignore
  expect(pair.value).toMatchObject({ first: 'room', second: 'hall', places: null });
  expect([personOf('room'), personOf('hall')]).toEqual(['this recording', 'Hall']);
  expect(groups.value).toEqual([]);
});

test('a copy has the recording’s colours, its own labels theirs, and differences four', () => {
  const label = (id: number, name: string, color: string) => ({ id, name, category: name, color, visible: true, locked: false, instance: 0 }); // prettier-ignore
  const [car, van, tree] = [label(1, 'car', '#111111'), label(2, 'van', '#222222'), label(2, 'tree', '#333333')]; // prettier-ignore
  const first = { labels: Uint16Array.of(0, 1, 1, 2, 0), palette: [car, van] };
  const second = { labels: Uint16Array.of(2, 0, 1, 2, 0), palette: [car, tree] };
  expect(coloursOf(first.palette, second.palette, [car], 'dark').slice(5)).toEqual([
    '#222222',
    '#333333',
  ]);
  expect([...idsOf(first, second, [car], 'first', 100)]).toEqual([0, 1, 1, 105, 0]);
  expect([...idsOf(first, second, [car], 'second', 100)]).toEqual([106, 0, 1, 106, 0]);
  expect([...idsOf(first, second, [car], 'difference', 100)]).toEqual([101, 100, 103, 102, 104]);
  const head = new Uint8Array(10 + 6);
  head[8] = 6;
  const bytes = Uint8Array.of(...head, 5, 0, 1, 1);
  expect([...labelsOf(bytes.buffer)]).toEqual([5, 257]);
});
