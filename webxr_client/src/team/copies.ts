/** Agreement of people who label copies of one recording: where they differ, and whose is taken. */
import { computed, signal } from '@preact/signals';
import { projectPath } from '../engine/projects';
import { attempt, rowOf } from '../engine/recordings';
import { api } from '../net/rest';
import type { Agreement, Place } from '../reviewing/model';
import { notify, state } from '../store/state';
import { watch } from '../store/watch';
import { addTasks, goTo, project, tasks, teamOpen, teamTab } from './store';

export type Who = 0 | 1;

/** A difference of the second copy from the first in a frame; labels by name and by number. */
export interface Disagreement {
  readonly kind: 'missed' | 'added' | 'split' | 'merged' | 'renamed' | 'outline';
  readonly frame: number;
  readonly first: readonly string[];
  readonly second: readonly string[];
  readonly labels: readonly [readonly number[], readonly number[]];
  readonly points: number;
  /** Source coordinates; null in an octree. */
  readonly place: Place | null;
  /** Person that the recording agrees with there, or null. */
  readonly has: Who | null;
}

/** Agreement of two copies, by their ids. */
export interface Pair {
  readonly first: string;
  readonly second: string;
  readonly agreement: Agreement;
  readonly places: readonly Disagreement[];
}

/** Work of a person on frames of known truth; objects found, missed and added. */
export interface Score {
  readonly person: string;
  readonly frames: number;
  readonly miou: number | null;
  readonly found: number;
  readonly missed: number;
  readonly added: number;
}

/** The same disagreement in one frame or several, by frame. */
export interface Group {
  readonly key: string;
  readonly places: readonly Disagreement[];
  readonly points: number;
  /** Person that the recording agrees with in all of its frames, or null. */
  readonly has: Who | null;
}

/** Labels in the cloud: the recording's, the first's, the second's, or differences of both. */
export type Shows = 'recording' | 'first' | 'second' | 'difference';

/** null until the server has answered. */
export const pairs = signal<readonly Pair[] | null>(null);
export const scores = signal<readonly Score[]>([]);
/** Index of the pair that one looks at. */
export const at = signal(0);
export const pair = computed(() => pairs.value?.[at.value] ?? pairs.value?.[0] ?? null);
export const groups = computed(() => (pair.value ? grouped(pair.value.places) : []));
/** Key of the group that one looks at, and the frame in it. */
export const current = signal<{ readonly key: string; readonly frame: number } | null>(null);
export const shows = signal<Shows>('recording');
/** The recording whose copies are compared: the one that is open, or that it is a copy of. */
export const original = computed(() => {
  const open = state.sequence.value?.id;
  return rowOf(open)?.copy_of ?? open ?? null;
});
/** True while the tab is on screen. */
export const comparing = computed(() => teamOpen.value && teamTab.value === 'agreement');

/** Put what differs alike in several frames together, the most points first. */
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

/** The people who label a copy. */
export function personOf(copy: string): string {
  const own = tasks.value.filter(({ sequence, assignee }) => sequence === copy && assignee);
  return [...new Set(own.map(({ assignee }) => assignee))].join(' and ') || 'unassigned';
}

/** A disagreement in words; `names`: of both people. */
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

/** Answers to earlier questions are of no interest. */
let asked = 0;

export async function loadAgreement(): Promise<void> {
  const [sequence, turn] = [original.peek(), ++asked];
  if (!sequence || !project.peek()) return;
  await attempt('The people were not compared', async () => {
    const query = new URLSearchParams({ sequence }).toString();
    const found = await api<Pair[]>('GET', path(`agreement?${query}`));
    const told = await api<Score[]>('GET', path('scores'));
    if (turn === asked) [pairs.value, scores.value] = [found, told];
  });
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
export async function take(of: string, group?: Group, frame: number | null = null): Promise<void> {
  const between = pair.peek();
  const [first, second] = group?.places[0]?.labels ?? [];
  const region = between && first && second && {
    labels: { [between.first]: first, [between.second]: second },
    frame,
  }; // prettier-ignore
  await attempt('The labels were not merged', async () => {
    const body = { sequence: original.peek(), take: of, id: crypto.randomUUID() };
    await api('POST', path('merge'), region ? { ...body, region } : body);
    if (!group) notify('success', 'Merged', 'One undo reverts the merge.');
  });
  await loadAgreement();
}

/** Give the next person a copy without labels of this recording, whose own are right. */
export async function giveAsTruth(): Promise<void> {
  const made = await addTasks({ recordings: [original.peek()!], every: null, truth: true });
  if (made)
    notify(
      'success',
      'Ground truth task made',
      'The next annotator gets a copy. The score appears here.',
    );
}

const wanted = computed(() => (comparing.value && project.value ? original.value : null));

/** Compare anew when the tab is opened, or another recording; the result ends it. */
export function followCopies(): () => void {
  let told: string | null = null;
  return watch([wanted], () => {
    const now = wanted.peek();
    if (now === null) shows.value = 'recording';
    else void loadAgreement();
    if (now === null || now === told) return;
    told = now;
    [pairs.value, current.value, at.value] = [null, null, 0];
  });
}
