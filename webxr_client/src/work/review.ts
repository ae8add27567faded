/** States and findings of the open recording's frames, and the requests that change them. */
import { computed, signal } from '@preact/signals';
import { attempt, openPath, succeeds } from '../engine/recordings/recordings';
import { namesOf } from '../engine/review';
import { api } from '../net/rest';
import type { Checked, Finding, ReviewOverview, ReviewPatch } from '../protocol/values';
import { actions } from '../store/actions';
import { canReview, notify, state } from '../store/state';
import {
  acceptances,
  type Place,
  type ReviewState,
  STATE_WORDS,
  stepFrom,
  unsettled,
} from './model';
import { marked, pointing, visit } from './places';
import { openWork, shows } from './store';

/** null until the server has answered. */
export const overview = signal<ReviewOverview | null>(null);
export const checks = signal<Checked | null>(null);
export const checking = signal(false);
/** Id of the finding on screen. */
export const current = signal<string | null>(null);
export const waiting = computed(() => unsettled(checks.value?.findings ?? []));

/** Fetch a value of the open recording; null if another one was opened during the request. */
async function fetched<T>(rest: string): Promise<T | null> {
  const id = state.sequence.peek()?.id;
  const found = await api<T>('GET', openPath(rest));
  return state.sequence.peek()?.id === id ? found : null;
}

export async function loadStates(): Promise<void> {
  overview.value = (await fetched<ReviewOverview>('review')) ?? overview.peek();
}

async function check(): Promise<void> {
  checking.value = true;
  try {
    checks.value = (await fetched<Checked>('checks')) ?? checks.peek();
  } finally {
    checking.value = false;
  }
}

/** Load states, and findings while they are on screen. */
export const refreshReview = (): Promise<void> =>
  attempt('The states of the frames did not load', async () => {
    await loadStates();
    if (shows('findings')) await check();
  });

/** Another recording has been opened. */
export function forgetReview(): void {
  overview.value = checks.value = marked.value = current.value = pointing.value = null;
}

/** Set state, note or person of frames, or of a label; returns true if the server took it. */
export const put = (...patches: readonly ReviewPatch[]): Promise<boolean> =>
  succeeds('The state was not changed', async () => {
    for (const patch of patches)
      overview.value = await api<ReviewOverview>('PUT', openPath('review'), patch);
  });

interface Draft {
  readonly note: string;
  readonly place: Place | null;
  /** null: the frame on screen. */
  readonly first: number | null;
  readonly last: number | null;
}

const NOTHING: Draft = { note: '', place: null, first: null, last: null };
/** Draft of a note, kept while other tabs are shown. */
export const draft = signal<Draft>(NOTHING);

/** Set the state of the draft's frames, with its note. */
export async function judge(kind: ReviewState): Promise<boolean> {
  const { note, place, first, last } = draft.peek();
  const frame = state.frame.peek();
  const range = { first: first ?? frame, last: last ?? frame };
  const words = note.trim() ? { note: note.trim(), ...(place ? { place } : {}) } : {};
  const done = await put({ ...range, state: kind, ...words });
  if (done) draft.value = NOTHING;
  return done;
}

/** Set the state of the frame on screen; one to be corrected needs a note. */
export async function reviewFrame(kind: 'accepted' | 'rejected'): Promise<void> {
  if (!canReview.peek()) {
    notify('info', 'Only reviewers can check frames');
    return;
  }
  const frame = state.frame.peek();
  draft.value = { ...draft.peek(), first: null, last: null };
  if (!(await judge(kind))) return;
  notify('success', `Frame ${frame}: ${STATE_WORDS[kind]}`);
  if (kind === 'rejected') openWork('frames');
}

/** Select the label of a finding about one label, with a notice: the next stroke paints it. */
function selectLabelOf({ labels }: Finding): void {
  const [label, ...others] = labels;
  if (label === undefined || others.length > 0 || label === state.activeLabel.peek()) return;
  actions.labels.selectLabel(label);
  notify('info', `Active label: ${namesOf([label])}`, 'The next stroke paints this label.');
}

/** Go to a finding: its frame, its label if it is about one, its place. */
export function goToFinding(finding: Finding): void {
  current.value = finding.id;
  selectLabelOf(finding);
  visit(finding.first, finding.place);
}

export function step(direction: 1 | -1): void {
  const next = stepFrom(waiting.peek(), current.peek(), state.frame.peek(), direction);
  if (next) goToFinding(next);
  else notify('info', 'No suspicious places are left');
}

/** The same by a key: the findings are loaded first if they are not. */
export async function stepFindings(direction: 1 | -1): Promise<void> {
  openWork('findings');
  if (!checks.peek()) await refreshReview();
  if (checks.peek()) step(direction);
}

/** Confirm the labels of a finding as they are, and go to the next. */
export const settle = (finding: Finding): Promise<void> =>
  answer(finding, () => put(...acceptances(finding)));

/** Clear the tracked labels of a finding in its frames, and go to the next. */
export const deny = (finding: Finding): Promise<void> =>
  answer(finding, () => {
    const body = { labels: finding.labels, start: finding.first, stop: finding.last };
    return succeeds('The label was not cleared', () => api('POST', openPath('clear'), body));
  });

async function answer(finding: Finding, send: () => Promise<boolean>): Promise<void> {
  const next = stepFrom(waiting.peek(), finding.id, state.frame.peek(), 1);
  if (!(await send())) return;
  const found = checks.peek();
  if (found) {
    const settled = (one: Finding): Finding =>
      one.id === finding.id ? { ...one, settled: true } : one;
    checks.value = { ...found, findings: found.findings.map(settled) };
  }
  if (next && next.id !== finding.id) goToFinding(next);
}
