/** State of the review panel, and its requests to the server. */
import { computed, signal } from '@preact/signals';
import { actions } from '../store/actions';
import { attempt, sequencePath } from '../engine/recordings';
import { namesOf } from '../engine/review';
import { api } from '../net/rest';
import { canReview, notify, state } from '../store/state';
import { follow } from '../store/watch';
import {
  acceptances,
  type Checks,
  type Finding,
  type Overview,
  type Place,
  type ReviewPatch,
  type ReviewState,
  STATE_WORDS,
  stepFrom,
  unsettled,
} from './model';

export type ReviewTab = 'findings' | 'frames' | 'people' | 'agreement';

export const reviewOpen = signal(false);
export const reviewTab = signal<ReviewTab>('findings');
/** null until the server has answered. */
export const overview = signal<Overview | null>(null);
export const checks = signal<Checks | null>(null);
export const checking = signal(false);
/** Id of the finding that one looks at. */
export const current = signal<string | null>(null);
/** The place that the camera flew to, source coordinates; it is marked. */
export const marked = signal<Place | null>(null);
/** Receiver of the place that the next click points at; null when nobody points. */
export const pointing = signal<((place: Place) => void) | null>(null);

/** Tells the point in the middle of the picture, source coordinates; `Flight` fills it in. */
export const looking: { at: () => Place | null } = { at: () => null };

export const waiting = computed(() => unsettled(checks.value?.findings ?? []));

/** Others decide too, and nobody tells of it. */
const AGAIN_MS = 20_000;
/** Edits come one after the other: findings are looked for when there is a pause. */
const PAUSE_MS = 1200;

function path(rest: string): string {
  return `${sequencePath(state.sequence.peek()?.id ?? '')}/${rest}`;
}

/** Ask again for states and findings of the open recording. */
export async function refresh(): Promise<void> {
  const id = state.sequence.peek()?.id;
  if (!id) return;
  checking.value = true;
  try {
    await attempt('The review did not load', async () => {
      const told = await api<Overview>('GET', path('review'));
      const found = await api<Checks>('GET', path('checks'));
      if (state.sequence.peek()?.id !== id) return;
      overview.value = told;
      checks.value = found;
    });
  } finally {
    checking.value = false;
  }
}

/** Fetch what others have decided meanwhile; without a server things stay as they were. */
async function lookAgain(): Promise<void> {
  const id = state.sequence.peek()?.id;
  if (!id || !reviewOpen.peek() || document.hidden) return;
  const told = await api<Overview>('GET', path('review')).catch(() => null);
  if (told && state.sequence.peek()?.id === id) overview.value = told;
}

/** Set state, note or person of frames, or of a label; tells whether the server took it. */
export async function put(...patches: readonly ReviewPatch[]): Promise<boolean> {
  let done = false;
  await attempt('The review was not changed', async () => {
    for (const patch of patches) overview.value = await api<Overview>('PUT', path('review'), patch);
    done = true;
  });
  return done;
}

interface Draft {
  readonly note: string;
  readonly place: Place | null;
  /** null: the frame on screen. */
  readonly first: number | null;
  readonly last: number | null;
}

const NOTHING: Draft = { note: '', place: null, first: null, last: null };
/** Draft of a note, kept while other tabs are looked at. */
export const draft = signal<Draft>(NOTHING);

/** Say how frames are, with the note that was written: those of the form, or the one on screen. */
export async function judge(kind: ReviewState): Promise<boolean> {
  const { note, place, first, last } = draft.peek();
  const frame = state.frame.peek();
  const range = { first: first ?? frame, last: last ?? frame };
  const words = note.trim() ? { note: note.trim(), ...(place ? { place } : {}) } : {};
  const done = await put({ ...range, state: kind, ...words });
  if (done) draft.value = NOTHING;
  return done;
}

/** The same by a key, for the frame on screen; a rejected one wants a note. */
export async function judgeHere(kind: 'accepted' | 'rejected'): Promise<void> {
  if (!canReview.peek()) {
    notify('info', 'Only reviewers can accept and reject frames');
    return;
  }
  const frame = state.frame.peek();
  draft.value = { ...draft.peek(), first: null, last: null };
  if (!(await judge(kind))) return;
  notify('success', `Frame ${frame} is ${STATE_WORDS[kind]}`);
  if (kind === 'rejected') [reviewOpen.value, reviewTab.value] = [true, 'frames'];
}

/** Select the label of a finding about one label, with a notice: the next stroke paints it. */
function selectLabelOf({ labels }: Finding): void {
  const [label, ...others] = labels;
  if (label === undefined || others.length > 0 || label === state.activeLabel.peek()) return;
  actions.selectLabel(label);
  notify('info', `Active label: ${namesOf([label])}`, 'The next stroke paints this label.');
}

/** Go to a finding: its frame, its label if it is about one, its place. */
export function goTo(finding: Finding): void {
  current.value = finding.id;
  if (finding.first !== null) {
    actions.pause();
    actions.seek(finding.first);
  }
  selectLabelOf(finding);
  marked.value = finding.place && [...finding.place];
}

export function step(direction: 1 | -1): void {
  const next = stepFrom(waiting.peek(), current.peek(), state.frame.peek(), direction);
  if (next) goTo(next);
  else notify('info', 'No suspicious places are left');
}

/** The same by a key: findings are looked for first where that is still to be done. */
export async function stepFindings(direction: 1 | -1): Promise<void> {
  reviewOpen.value = true;
  if (!checks.peek()) await refresh();
  if (checks.peek()) step(direction);
}

/** A reviewer says that it is right as it is; on to the next. */
export async function settle(finding: Finding): Promise<void> {
  const next = stepFrom(waiting.peek(), finding.id, state.frame.peek(), 1);
  if (!(await put(...acceptances(finding)))) return;
  const found = checks.peek();
  if (found) {
    const settled = (one: Finding): Finding =>
      one.id === finding.id ? { ...one, settled: true } : one;
    checks.value = { ...found, findings: found.findings.map(settled) };
  }
  if (next && next.id !== finding.id) goTo(next);
}

/** Go to a place in a frame. */
export function visit(frame: number | null, place: Place | null): void {
  if (frame !== null) {
    actions.pause();
    actions.seek(frame);
  }
  marked.value = place && [...place];
}

export function closeReview(): void {
  reviewOpen.value = false;
  marked.value = null;
  pointing.value = null;
}

/** Look again whenever labels changed, while the panel is open; forget another recording's. */
export function followEdits(): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let shown = '';
  const stop = follow(() => {
    const id = state.sequence.value?.id ?? '';
    const edits = [state.timeline.value, state.palette.value];
    if (id !== shown) {
      shown = id;
      overview.value = checks.value = marked.value = current.value = pointing.value = null;
    }
    clearTimeout(timer);
    if (!reviewOpen.value || !id || edits.length === 0) return;
    timer = setTimeout(() => void refresh(), checks.peek() ? PAUSE_MS : 0);
  });
  const again = setInterval(() => void lookAgain(), AGAIN_MS);
  return () => {
    clearInterval(again);
    clearTimeout(timer);
    stop();
  };
}
