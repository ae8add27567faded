import type { ProjectInfo } from '../protocol/values';
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { projects, settled } from '../engine/recordings/projects';
import { state } from '../store/state';
import {
  addWebhook,
  deliveries,
  secret,
  selectCategory,
  setRole,
  settledProject,
  taxonomy,
} from './settings';

const night = { id: 'night', name: 'Night', role: 'manager', roles: {}, categories: null, recordings: [] } as unknown as ProjectInfo; // prettier-ignore
let sent: [string, unknown][] = [];
/** The project as the server has it. */
let kept: ProjectInfo = night;

beforeEach(() => {
  sent = [];
  kept = night;
  vi.stubGlobal('document', { baseURI: 'http://host/' });
  vi.stubGlobal('fetch', (url: string, { method, body }: RequestInit) => {
    const path = url.replace('http://host/api/v1/', '');
    const sentBody: unknown = body ? JSON.parse(body as string) : undefined;
    if (method !== 'GET') sent.push([`${method} ${path}`, sentBody]);
    if (method === 'PATCH') kept = { ...kept, ...(sentBody as object) };
    return Promise.resolve(Response.json(answer(method!, path)));
  });
  state.sequence.value = null;
  projects.value = [night];
  settled.value = 'night';
  taxonomy.value = [1, 2, 4].map((number) => ({
    ...{ number, name: `class ${number}`, color: '', datasets: {}, size: null, spread: null },
  }));
});
afterEach(() => void vi.unstubAllGlobals());

function answer(method: string, path: string): unknown {
  if (path === 'projects') return [kept];
  if (path.endsWith('/deliveries')) return [{ id: 'e', delivered: null, error: 'answered 500' }];
  if (path.endsWith('/webhooks')) {
    const hook = { id: 'w', url: 'https://a', topics: ['job'] };
    return method === 'POST' ? { ...hook, secret: 'hush' } : [hook];
  }
  return kept;
}

test('people who are given roles one after the other all have theirs', async () => {
  const first = setRole('ada', 'annotator');
  expect(settledProject.value?.roles).toEqual({ ada: 'annotator' });
  await Promise.all([first, setRole('grace', 'reviewer')]);
  await setRole('ada', null);
  expect(sent.map(([, patch]) => patch)).toEqual([
    { roles: { ada: 'annotator' } },
    { roles: { ada: 'annotator', grace: 'reviewer' } },
    { roles: { grace: 'reviewer' } },
  ]);
});

test('a category that is left out makes a selection, and all of them are none', async () => {
  await selectCategory(2, false);
  expect(settledProject.value?.categories).toEqual([1, 4]);
  await selectCategory(2, true);
  expect(sent.map(([, patch]) => patch)).toEqual([{ categories: [1, 4] }, { categories: null }]);
});

test('the secret of a new webhook is shown, and what became of its events', async () => {
  expect(await addWebhook('https://a', ['job'])).toBe(true);
  expect(secret.value).toEqual({ webhook: 'w', words: 'hush' });
  expect(deliveries.value.get('w')).toMatchObject([{ error: 'answered 500' }]);
});
