import { beforeEach, expect, it, vi } from 'vitest';
import type { Label } from '../protocol/messages';
import type { Classifier, Place as Question } from '../protocol/values';
import { bindActions } from '../store/actions';
import { state } from '../store/state';
import { answerDoubt, answered, classifier, exampleOpen, question, takeBackAnswer } from './store';

const QUESTION: Question = {
  sequence: 'hall', frame: 0, centre: [1.5, 0, -2.25], radius: 0.2, points: 20,
  runs: [[3, 20]], classes: ['road', 'wall'], doubt: 0.5,
}; // prettier-ignore
const calls: [string, unknown][] = [];
let undone = 20;

beforeEach(() => {
  calls.length = 0;
  vi.stubGlobal('document', { baseURI: 'http://host/' });
  vi.stubGlobal('fetch', (url: string, { method, body }: RequestInit) => {
    const path = url.replace('http://host/api/v1/sequences/hall/', '');
    calls.push([`${method} ${path}`, body ? JSON.parse(body as string) : undefined]);
    if (path === 'undo') return Promise.resolve(Response.json({ edit: 'u', changed: undone }));
    if (path.startsWith('doubt?')) return Promise.resolve(Response.json([]));
    const labels = (calls.at(-1)![1] as { class: number | null } | undefined)?.class != null;
    const answer = labels ? Response.json({ edit: 'e1', changed: 20 }) : new Response(null, { status: 204 }); // prettier-ignore
    return Promise.resolve(answer);
  });
  bindActions({ time: { pause: () => undefined, seek: () => undefined } });
  exampleOpen.value = true;
  classifier.value = { id: 'kinds', classes: ['road', 'wall'] } as unknown as Classifier;
  state.sequence.value = { id: 'hall' } as never;
  state.palette.value = [{ id: 4, name: 'road', category: '' } as Label];
  state.shown.value = { ...state.shown.value, frame: 0 };
  state.notices.value = [];
  answered.value = [];
});

/** Answer the question, and take the answer back once the search for the next doubt is done. */
async function answerAndTakeBack(name: string | null): Promise<void> {
  question.value = QUESTION;
  expect(answerDoubt(name)).toBe(true);
  await vi.waitUntil(() => calls.some(([call]) => call.startsWith('GET doubt?')));
  calls.length = 0;
  expect(takeBackAnswer()).toBe(true);
  await vi.waitUntil(() => question.value === QUESTION);
}

it('takes back the edit of the answer, whatever was painted since', async () => {
  await answerAndTakeBack('road');
  expect(calls).toEqual([['POST undo', { edit: 'e1' }]]);
  undone = 15;
  await answerAndTakeBack('road');
  expect(state.notices.value.at(-1)?.detail).toContain('5 points of the piece');
});

it('takes back none of the classes at the place of the answer', async () => {
  await answerAndTakeBack(null);
  const [call] = calls[0]!;
  const query = new URLSearchParams(call.split('?')[1]);
  expect(call).toMatch(/^DELETE doubt\/answers/);
  expect([query.get('classifier'), query.getAll('centre')]).toEqual(['kinds', ['1.5', '0', '-2.25']]); // prettier-ignore
});
