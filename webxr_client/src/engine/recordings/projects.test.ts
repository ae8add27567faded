import type { ProjectInfo } from '../../protocol/values';
import { afterEach, expect, test, vi } from 'vitest';
import { state, type SequenceSummary } from '../../store/state';
import { grouped, importInto, moveRecording, NO_CONDITIONS, search } from './projects';
import { importPath } from './importing';

const row = (id: string, project: string) => ({ id, project }) as SequenceSummary;
const project = (id: string) => ({ id, name: id }) as ProjectInfo;
const calls: [string, string, string][] = [];

/** A server that answers each request with the same. */
function answering(value: unknown): void {
  calls.length = 0;
  vi.stubGlobal('document', { baseURI: 'http://host/' });
  vi.stubGlobal('fetch', (url: string, { method, body }: RequestInit) => {
    calls.push([method!, url.replace('http://host/api/v1/', ''), body as string]);
    return Promise.resolve(Response.json(value));
  });
}

afterEach(() => {
  importInto.value = 'default';
  vi.unstubAllGlobals();
});

test('recordings are under their projects, and none is lost with an unknown one', () => {
  const groups = grouped(
    [row('a', 'night'), row('b', 'day'), row('c', 'new')],
    [project('day'), project('night'), project('empty')],
  );
  const ids = groups.map((group) => [group.project.id, group.rows.map(({ id }) => id)]);
  expect(ids).toEqual([['day', ['b']], ['night', ['a']], ['empty', []], ['new', ['c']]]); // prettier-ignore
});

test('the server is asked for the conditions that are said, and for nothing without any', async () => {
  answering([row('a', 'night')]);
  expect(await search({ ...NO_CONDITIONS, person: '  ' })).toBeNull();
  expect(calls).toEqual([]);
  const met = await search({ ...NO_CONDITIONS, class: 'car', person: ' ada ' });
  expect([...met!]).toEqual(['a']);
  expect(calls[0]!.slice(0, 2)).toEqual(['GET', 'sequences?class=car&person=ada']);
});

test('a recording that is moved stands in its new project at once', async () => {
  answering([]);
  state.sequences.value = [row('a', 'day'), row('b', 'day')];
  await moveRecording('b', 'night');
  expect(calls[0]).toEqual(['PATCH', 'projects/night', '{"recordings":["b"]}']);
  expect(state.sequences.value.map((each) => each.project)).toEqual(['day', 'night']);
});

test('an import joins the project that was chosen', async () => {
  answering({ upload: null });
  importInto.value = 'night';
  await importPath('/data/a');
  expect(JSON.parse(calls[0]![2])).toEqual({ path: '/data/a', project: 'night' });
});
