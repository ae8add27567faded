/** State of label by example, and its requests to the server. */
import { computed, signal } from '@preact/signals';
import { attempt, sequencePath } from '../engine/recordings';
import { api, apiBytes } from '../net/rest';
import { actions } from '../store/actions';
import { canEdit, notify, state } from '../store/state';
import { marked } from '../work/places';
import {
  predictionOf,
  type Classifier,
  type Prediction,
  type Question,
  type Scope,
  type Shows,
} from './model';

export const exampleOpen = signal(false);
/** Classifiers of the workspace; null until the server has told them. */
export const classifiers = signal<readonly Classifier[] | null>(null);
/** The one that is asked, or null. */
export const classifier = signal<Classifier | null>(null);
export const shows = signal<Shows>('classes');
/** Points predicted in the frame on screen; null: nothing yet. */
export const predicted = signal<{ readonly points: number; readonly unsure: number } | null>(null);
/** Changes of the places that the classifier ignores. */
export const ignored = signal(0);
/** Something is asked of the server. */
export const asking = signal(false);
/** Frames in which doubts are looked for. */
export const scope = signal<Scope>('recording');
/** Tells the place of a large frame that one looks at, source coordinates; set by the picture. */
export const looking: { at: () => readonly number[] | undefined } = { at: () => undefined };
/** The place in doubt that one was led to. */
export const question = signal<Question | null>(null);

/** Whether the place of the question is on screen and may be painted. */
export const answerable = computed(
  () => canEdit.value && question.value?.frame === state.shown.value.frame,
);

/** The first or the second class of the question, or none of the classes. */
export type Answer = 0 | 1 | 'none';

/** The answer that was chosen, until it is carried out. */
export const answer = signal<Answer | null>(null);

/** Answer the question; false when there is none, or another frame is on screen. */
export function answerDoubt(choice: Answer): boolean {
  if (!answerable.peek()) return false;
  answer.value = choice;
  return true;
}

/** Open the bar, or close it; what was predicted goes with it. */
export function toggleExample(): void {
  if (exampleOpen.peek()) closeExample();
  else void openExample();
}

export function closeExample(): void {
  exampleOpen.value = false;
  leaveQuestion();
}

export async function openExample(): Promise<void> {
  exampleOpen.value = true;
  await attempt('The classifiers did not load', async () => {
    const found = await api<Classifier[]>('GET', 'classifiers');
    classifiers.value = found;
    const id = state.sequence.peek()?.id ?? '';
    classifier.value =
      found.find((one) => one.id === classifier.peek()?.id) ??
      found.find((one) => id in one.taught_by) ??
      found[0] ??
      null;
  });
}

export function chooseClassifier(id: string): void {
  classifier.value = classifiers.peek()?.find((one) => one.id === id) ?? null;
  leaveQuestion();
}

/** Make a classifier of what is painted in the open recording. */
export async function makeClassifier(): Promise<void> {
  const { id, name } = state.sequence.peek()!;
  asking.value = true;
  await attempt('The classifier was not trained', async () => {
    const made = await api<Classifier>('POST', 'classifiers', { name, recordings: [id] });
    classifiers.value = [...(classifiers.peek() ?? []), made];
    classifier.value = made;
  });
  asking.value = false;
}

/** Let the open recording teach the classifier as well. */
export async function teachHere(): Promise<void> {
  const { id } = classifier.peek()!;
  const recordings = [state.sequence.peek()!.id];
  await attempt('The classifier was not trained', async () => {
    const path = `classifiers/${encodeURIComponent(id)}/teach`;
    const taught = await api<Classifier>('POST', path, { recordings });
    classifiers.value = classifiers.peek()!.map((one) => (one.id === id ? taught : one));
    classifier.value = taught;
  });
}

export async function deleteClassifier(): Promise<void> {
  const { id } = classifier.peek()!;
  await attempt('The classifier was not deleted', async () => {
    await api('DELETE', `classifiers/${encodeURIComponent(id)}`);
    classifiers.value = classifiers.peek()!.filter((one) => one.id !== id);
    classifier.value = classifiers.peek()![0] ?? null;
  });
}

/** Fetch the prediction of a frame, or of what is near a place of it, source coordinates. */
export async function predict(
  frame: number,
  place: readonly number[] | undefined,
  signal: AbortSignal,
): Promise<Prediction> {
  const path = `${sequencePath(state.sequence.peek()!.id)}/frames/${frame}/prediction`;
  const body = { classifier: classifier.peek()!.id, place };
  return predictionOf(await apiBytes('POST', `${path}?format=stored`, body, signal));
}

/** Answer that a place is of no class: the classifier neither asks about it again nor labels it. */
export async function ignore({ frame, centre, radius, sequence }: Question): Promise<void> {
  const { id } = classifier.peek()!;
  const path = `${sequencePath(sequence)}/doubt/answers`;
  await attempt('The answer was not stored', async () => {
    await api('POST', path, { classifier: id, place: { frame, centre, radius } });
    const run = (): void =>
      void attempt('The answer was not taken back', async () => {
        await api('DELETE', `${path}?classifier=${encodeURIComponent(id)}`);
        ignored.value += 1;
      });
    notify('info', 'Ignored this place', 'It gets no label.', { label: 'Undo', run });
    ignored.value += 1;
  });
}

/** Go to the place whose answer would teach most. */
export async function nextDoubt(): Promise<void> {
  const chosen = classifier.peek();
  if (!exampleOpen.peek() || !chosen) return;
  const before = question.peek();
  asking.value = true;
  await attempt('The search for doubts failed', async () => {
    const places = await api<Question[]>('GET', doubtPath(chosen.id));
    const next = places.find((place) => !before || far(place, before)) ?? places[0];
    if (next) goTo(next);
    else
      notify(
        'info',
        'No doubtful places',
        'Turn the prediction into labels or paint more examples.',
      );
  });
  asking.value = false;
}

function doubtPath(id: string): string {
  const asked = new URLSearchParams({ classifier: id });
  if (scope.peek() === 'frame') asked.set('frame', String(state.frame.peek()));
  if (scope.peek() === 'workspace') asked.set('workspace', 'true');
  for (const x of looking.at() ?? []) asked.append('near', String(x));
  return `${sequencePath(state.sequence.peek()!.id)}/doubt?${asked.toString()}`;
}

/** True when two places are not the same one, asked again. */
function far(one: Question, other: Question): boolean {
  if (one.frame !== other.frame) return true;
  return Math.hypot(...one.centre.map((x, k) => x - other.centre[k]!)) > one.radius;
}

function goTo(place: Question): void {
  actions.pause();
  if (place.sequence !== state.sequence.peek()?.id) actions.openSequence(place.sequence);
  question.value = place;
  showPlace();
}

/** Go to the question's frame and place, once its recording is open. */
export function showPlace(): void {
  const place = question.peek();
  if (!place || place.sequence !== state.sequence.peek()?.id) return;
  actions.seek(place.frame);
  marked.value = [...place.centre];
}

export function leaveQuestion(): void {
  if (question.peek()) marked.value = null;
  question.value = null;
}

/** Write the prediction into labels, as one edit; `above` is the least confidence, 0..1. */
export async function applyPrediction(frames: string, above: number): Promise<void> {
  await attempt('The prediction was not applied', async () => {
    const path = `${sequencePath(state.sequence.peek()!.id)}/predictions`;
    await api('POST', path, { classifier: classifier.peek()!.id, frames, above });
  });
}
