import { afterEach, expect, test, vi } from 'vitest';
import { projects } from '../engine/recordings/projects';
import type { SequenceInfo } from '../protocol/messages';
import type { ProjectInfo, Snapshot } from '../protocol/values';
import { state, type SequenceSummary } from '../store/state';
import { compare, createSnapshot, difference, snapshots } from './snapshots';

const made: Snapshot = { id: 'v1', name: 'First', created: '', author: 'ada', recordings: {} };
const answers: ((value: unknown) => void)[] = [];
const calls: string[] = [];

vi.stubGlobal('document', { baseURI: 'http://host/' });
vi.stubGlobal('fetch', (url: string, { method }: RequestInit) => {
  calls.push(`${method} ${url.replace('http://host/api/v1/', '')}`);
  return new Promise<Response>((resolve) => {
    answers.push((value) => resolve(Response.json(value)));
  });
});
projects.value = [{ id: 'night', name: 'Night' } as ProjectInfo];
state.sequences.value = [{ id: 'room', project: 'night' } as SequenceSummary];
state.sequence.value = { id: 'room' } as SequenceInfo;
afterEach(() => void (answers.length = calls.length = 0));

test('a snapshot that was made stands first', async () => {
  snapshots.value = [{ ...made, id: 'v0' }];
  const done = createSnapshot('First');
  answers[0]!(made);
  expect(await done).toBe(true);
  expect(snapshots.value.map(({ id }) => id)).toEqual(['v1', 'v0']);
});

test('of two comparisons the one that was asked for last is shown', async () => {
  const early = compare(made);
  const late = compare({ ...made, id: 'v2' }, 'v1');
  expect(calls.map((call) => call.split('/').slice(2).join('/'))).toEqual([
    'snapshots/v1/difference',
    'snapshots/v2/difference?with=v1',
  ]); // prettier-ignore
  answers[1]!([{ sequence: 'room', labels: [], frames: [] }]);
  await late;
  answers[0]!([]);
  await early;
  expect(difference.value).toMatchObject({ with: 'v1', found: [{ sequence: 'room' }] });
});
