/** State of label by example, and its requests to the server. */
import { computed, signal } from '@preact/signals';
import { attempt, openPath, sequencePath, succeeds } from '../engine/recordings/recordings';
import { plural } from '../common/format';
import { api, apiBytes } from '../net/rest';
import type { Classifier, Place as Question } from '../protocol/values';
import { actions } from '../store/actions';
import { canEdit, notify, state } from '../store/state';
import { marked, markedFrom } from '../work/places';
import { workOpen } from '../work/store';
import { labelOf, predictionOf, type Prediction, type Scope } from './model';

/** Distance from which a doubt is looked at, in radii of its piece, and metres at least. */
const [VIEW_RADII, MIN_VIEW_METRES] = [10, 3];

export const exampleOpen = signal(false);
/** Classifiers of the workspace; null until the server has told them. */
export const classifiers = signal<readonly Classifier[] | null>(null);
/** Recordings with labels from which a new classifier can start. */
export const starts = signal<readonly string[]>([]);
/** The one that is asked, or null. */
export const classifier = signal<Classifier | null>(null);
/** The only class in colour; null: all. */
export const only = signal<string | null>(null);
/** The points have the recording's own colours, while a key is held. */
export const natural = signal(false);
/** Show the recording's own colours while something is held. */
export function showNatural(on: boolean): void {
  natural.value = on && exampleOpen.peek();
}

/** Prediction of the frame on screen; null: none yet. */
export const predicted = signal<Prediction | null>(null);
/** Changes of the places that the classifier ignores. */
export const ignored = signal(0);
/** A request to the server is open. */
export const isRequesting = signal(false);
/** Frames in which doubts are looked for. */
export const scope = signal<Scope>('recording');
/** Tells the place of a large frame that one looks at, source coordinates; set by the picture. */
export const looking = {
  at: (): readonly number[] | undefined => undefined,
  /** Mask of the predicted points without a label; null until the picture is there. */
  open: null as ((prediction: Prediction) => Uint8Array | null) | null,
};
/** The uncertain place on which a question is open. */
export const question = signal<Question | null>(null);

/** Whether the place of the question is on screen and may be painted. */
export const answerable = computed(
  () => canEdit.value && question.value?.frame === state.shown.value.frame,
);

/** Result of an edit, as REST tells it. */
interface Edited {
  readonly edit: string;
  readonly changed: number;
}

/** Answers that can be taken back, the last one last; without an edit: none of the classes. */
export const answered = signal<readonly { place: Question; edited: Edited | undefined }[]>([]);

/** Answer the question with a class, or with none; false when there is none, or another frame is on screen. */
export function answerDoubt(name: string | null | undefined): boolean {
  const place = question.peek();
  if (!place || name === undefined || !answerable.peek()) return false;
  void answer(place, name);
  return true;
}

/** Answer with the class of a number, from 1. */
export function answerNth(number: number): boolean {
  return answerDoubt(classifier.peek()?.classes[number - 1]);
}

async function answer(place: Question, name: string | null): Promise<void> {
  question.value = null;
  let edited: Edited | undefined;
  const stored = await succeeds('The answer was not stored', async () => {
    const known = name === null ? null : labelOf(name, state.palette.peek())?.id;
    const label = known === undefined ? await actions.labels.createLabel(name!) : known;
    edited = await send(place, { class: label });
  });
  if (!stored) {
    question.value = place;
    return;
  }
  answered.value = [...answered.peek(), { place, edited }];
  if (name === null) ignored.value += 1;
  await nextDoubt();
}

function send(
  { sequence, frame, centre, radius }: Question,
  answer: object,
): Promise<Edited | undefined> {
  const body = { classifier: classifier.peek()!.id, place: { frame, centre, radius }, ...answer };
  return api('POST', `${sequencePath(sequence)}/doubt/answers`, body);
}

/** Take back the last answer, and ask again; false when there is none. */
export function takeBackAnswer(): boolean {
  const last = answered.peek().at(-1);
  if (!exampleOpen.peek() || !last) return false;
  answered.value = answered.peek().slice(0, -1);
  void attempt('The answer was not taken back', async () => {
    const { place, edited } = last;
    const path = sequencePath(place.sequence);
    if (edited) await undoAnswer(path, edited);
    else {
      const query = new URLSearchParams({ classifier: classifier.peek()!.id });
      for (const x of place.centre) query.append('centre', String(x));
      await api('DELETE', `${path}/doubt/answers?${query.toString()}`);
      ignored.value += 1;
    }
    goTo(place);
  });
  return true;
}

/** Undo the edit of an answer alone; points with a later label keep it. */
async function undoAnswer(path: string, { edit, changed }: Edited): Promise<void> {
  const undone = await api<Edited>('POST', `${path}/undo`, { edit });
  if (undone.changed === changed) return;
  const kept = `${plural(changed - undone.changed, 'point')} of the piece got another label later, and keep it.`;
  notify('info', 'The answer was taken back in part', kept);
}

/** Go to the next place in doubt; one that is not answered is not asked about again. */
export async function skipDoubt(): Promise<void> {
  const place = question.peek();
  if (place && canEdit.peek())
    await attempt('The place was not skipped', async () => {
      await send(place, { class: null, skip: true });
    });
  await nextDoubt();
}

/** Open or close the bar; closing removes the prediction. */
export function toggleExample(): void {
  if (exampleOpen.peek()) closeExample();
  else void openExample();
}

export function closeExample(): void {
  exampleOpen.value = natural.value = false;
  only.value = null;
  answered.value = [];
  leaveQuestion();
}

export async function openExample(): Promise<void> {
  exampleOpen.value = true;
  workOpen.value = false;
  await attempt('The classifiers did not load', async () => {
    const found = await api<Classifier[]>('GET', 'classifiers');
    classifiers.value = found;
    const id = state.sequence.peek()?.id ?? '';
    classifier.value =
      found.find((one) => one.id === classifier.peek()?.id) ??
      found.find((one) => id in one.taught_by) ??
      found[0] ??
      null;
    if (!canEdit.peek()) return;
    const others = await api<{ recording: string }[]>('GET', `${sequencePath(id)}/starts`);
    starts.value = others.map(({ recording }) => recording);
  });
}

export function chooseClassifier(id: string): void {
  classifier.value = classifiers.peek()?.find((one) => one.id === id) ?? null;
  answered.value = [];
  leaveQuestion();
}

/** Create a classifier from points painted in the open recording and labels of others. */
export async function makeClassifier(others: readonly string[] = []): Promise<void> {
  const { id, name } = state.sequence.peek()!;
  const more = others.length > 0 ? { start_from: others } : {};
  isRequesting.value = true;
  await attempt('The classifier was not trained', async () => {
    const made = await api<Classifier>('POST', 'classifiers', { name, recordings: [id], ...more });
    classifiers.value = [...(classifiers.peek() ?? []), made];
    classifier.value = made;
  });
  isRequesting.value = false;
}

/** Let the open recording teach the classifier as well. */
export async function teachOpenRecording(): Promise<void> {
  const { id } = classifier.peek()!;
  const more = { recordings: [state.sequence.peek()!.id] };
  await attempt('The classifier was not trained', async () => {
    const path = `classifiers/${encodeURIComponent(id)}/teach`;
    const taught = await api<Classifier>('POST', path, more);
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

/** Fetch the prediction of a frame, or of the points near a place, source coordinates. */
export async function predict(
  frame: number,
  place: readonly number[] | undefined,
  signal: AbortSignal,
): Promise<Prediction> {
  const path = openPath(`frames/${frame}/prediction`);
  const body = { classifier: classifier.peek()!.id, place };
  return predictionOf(await apiBytes('POST', `${path}?format=stored`, body, signal));
}

/** Go to the most informative place, of all or `between` two classes. */
export async function nextDoubt(between: readonly string[] = []): Promise<void> {
  const chosen = classifier.peek();
  if (!exampleOpen.peek() || !chosen) return;
  isRequesting.value = true;
  await attempt('The search for doubts failed', async () => {
    const before = question.peek();
    const [next] = await api<Question[]>('GET', doubtPath(chosen.id, between));
    if (question.peek() !== before) return; // an answer was taken back meanwhile
    if (next) {
      goTo(next);
      return;
    }
    leaveQuestion();
    notify('info', 'No doubtful places', 'Turn the prediction into labels or paint more examples.');
  });
  isRequesting.value = false;
}

function doubtPath(id: string, between: readonly string[]): string {
  const query = new URLSearchParams({ classifier: id, format: 'stored', most: '1' });
  if (scope.peek() === 'frame') query.set('frame', String(state.frame.peek()));
  if (scope.peek() === 'workspace') query.set('workspace', 'true');
  for (const name of between) query.append('between', name);
  for (const x of looking.at() ?? []) query.append('near', String(x));
  return openPath(`doubt?${query.toString()}`);
}

function goTo(place: Question): void {
  actions.time.pause();
  if (place.sequence !== state.sequence.peek()?.id) actions.recordings.openSequence(place.sequence);
  question.value = place;
  showPlace();
}

/** Go to the question's frame and place, once its recording is open. */
export function showPlace(): void {
  const place = question.peek();
  if (!place || place.sequence !== state.sequence.peek()?.id) return;
  actions.time.seek(place.frame);
  markedFrom.value = Math.max(MIN_VIEW_METRES, VIEW_RADII * place.radius);
  marked.value = [...place.centre];
}

export function leaveQuestion(): void {
  if (question.peek()) marked.value = null;
  question.value = null;
}

/** Write the prediction into labels, as one edit; `above` is the least confidence, 0..1. */
export async function applyPrediction(frames: string, above: number): Promise<void> {
  await attempt('The prediction was not applied', async () => {
    const path = openPath('predictions');
    await api('POST', path, { classifier: classifier.peek()!.id, frames, above });
  });
}
