import type { Classifier, Place as Question } from '../../protocol/values';
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { classifier, exampleOpen, natural, question } from '../../example/store';
import { state } from '../../store/state';
import { Bench } from '../testing/bench';
import { registered } from '../testing/registry';
import type { TestSource } from '../testing/sources';

const [QUEST, VIVE] = ['meta-quest-touch-plus', 'htc-vive'];
const PLACE: Question = {
  sequence: 'a', frame: 0, centre: [0, 0, -3], radius: 0.1, points: 20, doubt: 0.5, runs: [],
  classes: ['road', 'wall'],
}; // prettier-ignore
const answers: unknown[] = [];
let bench: Bench;
let hand: TestSource;

beforeEach(() => {
  answers.length = 0;
  exampleOpen.value = true;
  classifier.value = { id: 'kinds', classes: ['car', 'road', 'wall'] } as unknown as Classifier;
});

afterEach(() => {
  bench.dispose();
  exampleOpen.value = natural.value = false;
  question.value = null;
});

function wear(profile: string): void {
  hand = registered(profile, 'right');
  bench = new Bench(hand);
  state.palette.value = ['car', 'road', 'wall'].map((name, k) => ({ ...state.palette.value[k]!, name, category: '' })); // prettier-ignore
  state.shown.value = { ...state.shown.value, frame: 0 };
  vi.stubGlobal('document', { baseURI: 'http://host/' });
  vi.stubGlobal('fetch', (url: string, { body }: RequestInit) => {
    if (url.endsWith('/answers')) answers.push((JSON.parse(body as string) as { class: number | null }).class); // prettier-ignore
    return Promise.resolve(url.endsWith('/answers') ? new Response(null, { status: 204 }) : Response.json([])); // prettier-ignore
  });
}

/** Let the thumb push to a height, `pushes` times, and let go; answers are sent afterwards. */
async function push(y: number, pushes = 1): Promise<void> {
  const { axes } = hand.gamepad!;
  const pad = axes.length === 2;
  axes[axes.length - 1] = y;
  if (pad) hand.press(2, 1);
  bench.go(pushes === 1 ? 2 : 2 + Math.ceil((pushes - 1) * 18));
  axes[axes.length - 1] = 0;
  if (pad) hand.press(2, 0);
  bench.go(2);
  await new Promise(setImmediate);
}

it.each([QUEST, VIVE])('a push answers for the piece that the hand points at: %s', async (profile) => {
  wear(profile);
  for (const [y, label] of [[-1, 2], [1, 3]] as const) {
    question.value = PLACE;
    await push(y);
    expect([answers.pop(), state.activeLabel.value]).toEqual([label, 1]);
  }
  question.value = { ...PLACE, centre: [3, 0, 0] };
  await push(1);
  expect([answers, state.activeLabel.value]).toEqual([[], 2]);
}); // prettier-ignore

it('a push that is held on reaches the other classes and none of them, and answers once', async () => {
  wear(QUEST);
  question.value = PLACE;
  await push(-1, 2);
  expect(answers).toEqual([null]);
  wear(VIVE);
  question.value = PLACE;
  await push(-1, 4);
  expect(answers).toEqual([null, 2]);
});

it('the grip shows the natural colours while it is held', () => {
  wear(QUEST);
  hand.squeeze = 1;
  bench.go(2);
  expect(natural.value).toBe(true);
  hand.squeeze = 0;
  bench.go(2);
  expect(natural.value).toBe(false);
  exampleOpen.value = false;
  hand.squeeze = 1;
  bench.go(2);
  expect(natural.value).toBe(false);
});
