/** Agreement of two people on the same points: in copies of the recording, or in another import. */
import { computed, signal } from '@preact/signals';
import { projectPath } from '../engine/recordings/projects';
import { attempt, rowOf, sequencePath, succeeds } from '../engine/recordings/recordings';
import { api } from '../net/rest';
import type { Agreement, CopyAgreement, Disagreement, Score } from '../protocol/values';
import { notify, state } from '../store/state';
import { watch } from '../store/watch';
import { goTo } from './places';
import { addTasks, tasks } from './queue';
import { project, shows as onScreen } from './store';

/** Agreement of two copies or recordings, by their ids. */
export interface Pair extends Omit<CopyAgreement, 'places'> {
  /** null: another recording, of which the server finds no places. */
  readonly places: readonly Disagreement[] | null;
}

/** The same disagreement in one frame or several, by frame. */
export interface Group {
  readonly key: string;
  readonly places: readonly Disagreement[];
  readonly points: number;
  /** Person that the recording agrees with in all of its frames, or null. */
  readonly has: number | null;
}

/** Labels in the cloud: the recording's, the first's, the second's, or differences of both. */
export type Shows = 'recording' | 'first' | 'second' | 'difference';

/** Pairs of copies, and the other recordings that were compared; null: not answered yet. */
export const pairs = signal<readonly Pair[] | null>(null);
export const scores = signal<readonly Score[]>([]);
/** Key of the pair that was chosen, or "" for the first. */
export const chosenPair = signal('');
export const pair = computed(() => {
  const all = pairs.value ?? [];
  const key = chosenPair.value;
  return (key ? all.find((each) => keyOf(each) === key) : all[0]) ?? null;
});
export const groups = computed(() => grouped(pair.value?.places ?? []));
/** Key of the group on screen, and the frame in it. */
export const current = signal<{ readonly key: string; readonly frame: number } | null>(null);
export const shows = signal<Shows>('recording');
/** The recording with the compared copies: the open one, or the original of the open copy. */
export const original = computed(() => {
  const open = state.sequence.value?.id;
  return rowOf(open)?.copy_of ?? open ?? null;
});
/** Other recordings that may have the same points. */
export const others = computed(() => {
  const frames = rowOf(original.value ?? undefined)?.frames;
  const rows = state.sequences.value ?? [];
  return rows.filter((row) => row.id !== original.value && row.frames === frames && !row.damaged);
});

export const keyOf = ({ first, second }: Pick<Pair, 'first' | 'second'>): string =>
  `${first}/${second}`;

/** Group equal differences in several frames, the most points first. */
export function grouped(places: readonly Disagreement[]): readonly Group[] {
  const found = new Map<string, Disagreement[]>();
  for (const place of places) {
    const key = JSON.stringify([place.kind, place.labels]);
    found.set(key, [...(found.get(key) ?? []), place]);
  }
  return [...found]
    .map(([key, of]) => ({
      key,
      places: of.sort((a, b) => a.frame - b.frame),
      points: of.reduce((sum, { points }) => sum + points, 0),
      has: of.every(({ has }) => has === of[0]!.has) ? of[0]!.has : null,
    }))
    .sort((a, b) => b.points - a.points);
}

/** The annotators of a copy, or the name of a recording. */
export function personOf(id: string): string {
  const row = rowOf(id);
  if (row && !row.copy_of) return id === original.value ? 'this recording' : row.name;
  const own = tasks.value.filter(({ sequence, assignee }) => sequence === id && assignee);
  return [...new Set(own.map(({ assignee }) => assignee))].join(' and ') || 'unassigned';
}

/** Return the text of a disagreement; `names`: of both people. */
export function wordsOf(place: Disagreement, [one, other]: readonly [string, string]): string {
  const first = place.first.join(', ');
  const second = place.second.join(', ');
  switch (place.kind) {
    case 'missed':
      return `${first}: only ${one} has it`;
    case 'added':
      return `${second}: only ${other} has it`;
    case 'split':
      return `${first}: ${other} has ${place.second.length} parts`;
    case 'merged':
      return `${second}: ${one} has ${place.first.length} parts`;
    case 'renamed':
      return `${first}: ${other} calls it ${second}`;
    case 'outline':
      return `${first}: different outlines`;
  }
}

const path = (rest: string): string => `${projectPath(project.peek()?.id ?? '')}/${rest}`;

/** Number of the last request: answers to earlier ones are dropped. */
let newestRequest = 0;

export async function loadAgreement(): Promise<void> {
  const [sequence, turn] = [original.peek(), ++newestRequest];
  if (!sequence || !project.peek()) return;
  await attempt('The people were not compared', async () => {
    const query = new URLSearchParams({ sequence }).toString();
    const found = await api<Pair[]>('GET', path(`agreement?${query}`));
    const newScores = await api<Score[]>('GET', path('scores'));
    if (turn === newestRequest) [pairs.value, scores.value] = [found, newScores];
  });
  if (!pair.peek()) await choose(chosenPair.peek());
}

/** Show a pair; another recording is compared first. */
export async function choose(key: string): Promise<void> {
  [chosenPair.value, current.value] = [key, null];
  const [first, second] = key.split('/');
  if (!first || !second || pair.peek()) return;
  const done = await succeeds('The recordings were not compared', async () => {
    const query = new URLSearchParams({ with: second }).toString();
    const agreement = await api<Agreement>('GET', `${sequencePath(first)}/agreement?${query}`);
    pairs.value = [...(pairs.peek() ?? []), { first, second, agreement, places: null }];
  });
  if (!done && chosenPair.peek() === key) chosenPair.value = '';
}

/** Fly to a place of a group: in the recording, whichever copy is open. */
export function visitGroup(group: Group, place: Disagreement = largest(group)): void {
  current.value = { key: group.key, frame: place.frame };
  goTo(original.peek()!, place.frame, place.place);
}

function largest({ places }: Group): Disagreement {
  return places.reduce((best, each) => (each.points > best.points ? each : best));
}

/** Take the labels of a copy, or of the majority: all, or only at the places of a group. */
export async function take(of: string, group?: Group): Promise<void> {
  const between = pair.peek();
  const [first, second] = group?.places[0]?.labels ?? [];
  const region = between && first && second && {
    labels: { [between.first]: first, [between.second]: second },
    frame: null,
  }; // prettier-ignore
  await attempt('The labels were not merged', async () => {
    const body = { sequence: original.peek(), take: of, id: crypto.randomUUID() };
    await api('POST', path('merge'), region ? { ...body, region } : body);
    if (!group) notify('success', 'Merged', 'One undo reverts the merge.');
  });
  await loadAgreement();
}

/** Make a task with a copy without labels; the labels of this recording are ground truth. */
export async function giveAsTruth(): Promise<void> {
  const made = await addTasks({ recordings: [original.peek()!], every: null, truth: true });
  const next = 'The next annotator gets a copy. The score appears here.';
  if (made) notify('success', 'Ground truth task made', next);
}

const wanted = computed(() => (onScreen('agreement') && project.value ? original.value : null));

/** Compare again when the tab or another recording is opened; the result ends it. */
export function followCopies(): () => void {
  let compared: string | null = null;
  return watch([wanted], () => {
    const now = wanted.peek();
    if (now === null) shows.value = 'recording';
    else void loadAgreement();
    if (now === null || now === compared) return;
    compared = now;
    [pairs.value, current.value, chosenPair.value] = [null, null, ''];
  });
}
