import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { projects } from '../engine/recordings/projects';
import type { SequenceInfo } from '../protocol/messages';
import type { PastEdit, ProjectInfo, Task } from '../protocol/values';
import { bindActions } from '../store/actions';
import { state, type Me, type SequenceSummary } from '../store/state';
import { follow } from '../store/watch';
import { arrive, looking, marked } from './places';
import { accept, begin, giveBack, mine, nextTask, question, tasks } from './queue';

const task = (number: number, more: Partial<Task> = {}): Task => ({
  number, sequence: 'room', first: 0, last: 4, state: 'taken', assignee: 'ada', reviewer: '',
  note: '', frame: null, place: null, created: '', changed: '', ...more,
}); // prettier-ignore
const edit = (more: Partial<PastEdit> = {}): Partial<PastEdit> => ({
  author: 'ada', kind: 'paint', time: '2026-01-02T11:00:00Z', frames: [3], undone: false, ...more,
}); // prettier-ignore
const night = { id: 'night', name: 'Night', role: 'annotator', recordings: ['room'] };
let calls: [string, unknown][] = [];
let next: Task | null = null;
let edits: Partial<PastEdit>[] = [];
let events: { state: string; at: string }[] = [];
const seek = vi.fn();
const openSequence = vi.fn();
let stop = (): void => undefined;

beforeEach(() => {
  calls = [];
  events = [
    { state: 'taken', at: '2026-01-02T10:00:00Z' },
    { state: 'open', at: '2026-01-02T09:00:00Z' },
  ];
  edits = [edit()];
  vi.stubGlobal('document', { baseURI: 'http://host/', hidden: false });
  vi.stubGlobal('fetch', (url: string, { method, body }: RequestInit) => {
    const path = url.replace('http://host/api/v1/', '');
    const sent: unknown = body ? JSON.parse(body as string) : undefined;
    if (method !== 'GET') calls.push([`${method} ${path}`, sent]);
    const number = Number(path.split('/').at(-1));
    const reply =
      method === 'PATCH' ? { ...task(number), ...(sent as object) }
      : method === 'POST' ? next
      : path.includes('/edits') ? edits
      : path.endsWith('/history') ? events
      : path === 'projects' ? [night] : tasks.peek(); // prettier-ignore
    return Promise.resolve(Response.json(reply));
  });
  bindActions({
    time: { seek },
    recordings: { refreshSequences: () => Promise.resolve(), openSequence },
  });
  projects.value = [night as unknown as ProjectInfo];
  state.me.value = { author: 'ada', account: 'owner:1' } as Me;
  state.sequences.value = [
    { id: 'room', name: 'Room', project: 'night' } as SequenceSummary,
    { id: 'hall', name: 'Hall', project: 'night' } as SequenceSummary,
  ];
  state.sequence.value = { id: 'room', frames: 9 } as SequenceInfo;
  state.framed.value = true;
  stop = follow(arrive);
});
afterEach(() => {
  stop();
  vi.unstubAllGlobals();
  vi.clearAllMocks();
});

test('one key hands in the task of the open recording and begins the next', async () => {
  tasks.value = [task(1), task(2, { state: 'open', assignee: '' })];
  next = task(2, { first: 5, last: 8 });
  await nextTask();
  expect(calls).toEqual([
    ['PATCH projects/night/tasks/1', { state: 'done' }],
    ['POST projects/night/tasks/next', { work: 'label' }],
  ]);
  expect(seek).toHaveBeenCalledWith(5);
});

test.each([
  ['no edit', []],
  ['the edit of another person', [edit({ author: 'bob' })]],
  ['an edit of other frames', [edit({ frames: [7] })]],
  ['an edit before the task', [edit({ time: '2026-01-01T09:00:00Z' })]],
  ['an edit that was undone', [edit({ kind: 'undo' }), edit({ undone: true })]],
])('a task with %s is handed in after a question only', async (_, found) => {
  edits = found;
  tasks.value = [task(1)];
  const kept = nextTask();
  await vi.waitFor(() => expect(question.value?.task.number).toBe(1));
  question.value!.answer(false);
  await kept;
  expect(calls).toEqual([]);
  const done = nextTask();
  await vi.waitFor(() => expect(question.value).not.toBe(null));
  question.value!.answer(true);
  await done;
  expect(calls[0]).toEqual(['PATCH projects/night/tasks/1', { state: 'done' }]);
  expect(question.value).toBe(null);
});

test('edits before a task was returned are no answer to its note', async () => {
  events = [{ state: 'taken', at: '2026-01-02T13:00:00Z' }, { state: 'returned', at: '2026-01-02T12:00:00Z' }, ...events]; // prettier-ignore
  tasks.value = [task(1)];
  void nextTask();
  await vi.waitFor(() => expect(question.value?.task.number).toBe(1));
  question.value!.answer(false);
});

test('a task whose recording is not open is gone to, and not handed in', async () => {
  tasks.value = [task(1, { sequence: 'hall' })];
  next = tasks.value[0]!;
  await nextTask();
  expect(calls.map(([call]) => call)).toEqual(['POST projects/night/tasks/next']);
  expect(openSequence).toHaveBeenCalledWith('hall');
});

test('what was returned is flown to once its recording is open', async () => {
  next = task(3, { sequence: 'hall', note: 'a handle', frame: 2, place: [1, 2, 3] });
  await begin('night');
  expect(marked.value).not.toEqual([1, 2, 3]);
  state.framed.value = false;
  state.sequence.value = { id: 'hall', frames: 9 } as SequenceInfo;
  await Promise.resolve();
  expect(seek).not.toHaveBeenCalled();
  state.framed.value = true;
  await Promise.resolve();
  expect(seek).toHaveBeenCalledWith(2);
  expect(marked.value).toEqual([1, 2, 3]);
});

test('own tasks are those begun, then those returned; others are not', () => {
  tasks.value = [
    task(1, { state: 'returned' }),
    task(2),
    task(3, { assignee: 'bob' }),
    task(4, { state: 'accepted' }),
  ];
  expect(mine.value.map(({ number }) => number)).toEqual([2, 1]);
});

test('a task is sent back with the middle of the picture, in one of its frames only', async () => {
  looking.at = () => [4, 5, 6];
  state.frame.value = 3;
  await giveBack(task(1), 'the roof', null);
  expect(calls[0]![1]).toEqual({ state: 'returned', note: 'the roof', frame: 3, place: [4, 5, 6] });
  state.frame.value = 7;
  await giveBack(task(1), 'the roof', null);
  expect(calls[1]![1]).toEqual({ state: 'returned', note: 'the roof' });
});

test('a task of another person is accepted', async () => {
  tasks.value = [task(1, { state: 'done', assignee: 'bob' })];
  expect(await accept(tasks.value[0]!)).toBe(true);
  expect(calls).toEqual([['PATCH projects/night/tasks/1', { state: 'accepted' }]]);
});
