/** Doubt: labels to check in this frame, and a run that stopped for doubt and its continuation. */
import { computed, type ReadonlySignal, signal } from '@preact/signals';
import { actions, type ActionParts, type TrackRequest } from '../store/actions';
import { api } from '../net/rest';
import { cellKind, hasPoints, wantsLook } from '../store/cells';
import { trackableLabels } from '../store/palette-list';
import { dismiss, notify, state, type TimelineRow } from '../store/state';
import { follow } from '../store/watch';
import { attempt, openPath } from './recordings/recordings';

interface Halt {
  /** The frame that it stopped at, and the one that it was to reach. */
  readonly at: number;
  readonly stop: number;
  readonly labels: readonly number[];
}

/** A run that stopped because it was not sure; null when none waits to go on. */
export const halted = signal<Halt | null>(null);

const unsureText = computed(() => {
  if (state.playing.value) return '';
  const { rows } = state.timeline.value;
  const frame = state.frame.value;
  const doubtful = [...rows].filter(([, row]) => wantsLook(cellKind(row, frame)));
  return doubtful.map(([label]) => label).join(' ');
});

/** The text before the names of doubtful labels. */
export const DOUBT_PREFIX = 'Doubtful here';

/** Labels that are doubtful or lost in the frame at which time stands. */
export const unsure: ReadonlySignal<readonly number[]> = computed(() =>
  unsureText.value ? unsureText.value.split(' ').map(Number) : [],
);

/** The request of the run that goes on now, if it is one that stops. */
let runningRequest: TrackRequest | null = null;
/** Request of the run that waits. */
let stopped: TrackRequest | null = null;
/** The table of the run's frames may come a little after its end. */
const PATIENCE_MS = 3000;

/** Record the request of a run. */
export function startRun(request: TrackRequest): void {
  runningRequest = request.stop_unsure ? request : null;
  stopped = null;
  halted.value = null;
}

/** Another recording: its frames have nothing to do with a run of this one. */
export function forgetRun(): void {
  runningRequest = stopped = null;
  halted.value = null;
}

/** A run has ended: go to the frame where it stopped, and replace the notice `message`. */
export function endRun(message: number | null): void {
  const request = runningRequest;
  runningRequest = null;
  if (!request) return;
  const { id } = state.sequence.peek() ?? {};
  let done = false;
  const stopLooking = follow(() => {
    const { rows } = state.timeline.value;
    if (done || state.sequence.peek()?.id !== id) return;
    const found = firstDoubt(request, rows);
    if (!found) return;
    done = true;
    queueMicrotask(() => {
      stopLooking();
      if (message !== null) dismiss(message);
      halt(request, found);
    });
  });
  setTimeout(stopLooking, PATIENCE_MS);
}

/** Labels by their names, for a sentence. */
export function namesOf(labels: readonly number[]): string {
  const palette = state.palette.peek();
  return labels.map((id) => palette.find((label) => label.id === id)?.name ?? 'A label').join(', ');
}

interface Doubt {
  readonly frame: number;
  readonly label: number;
}

/** The first frame of a run, in its own direction, that a label is doubtful in. */
function firstDoubt(
  { labels, start, stop }: TrackRequest,
  rows: ReadonlyMap<number, TimelineRow>,
): Doubt | null {
  const step = stop < start ? -1 : 1;
  for (let frame = start + step; frame !== stop + step; frame += step) {
    for (const [label, row] of rows) {
      if (labels && !labels.includes(label)) continue;
      if (wantsLook(cellKind(row, frame))) return { frame, label };
    }
  }
  return null;
}

function halt(request: TrackRequest, { frame, label }: Doubt): void {
  const labels = request.labels ?? [...state.timeline.peek().rows.keys()];
  stopped = request;
  halted.value = { at: frame, stop: request.stop, labels };
  actions.time.pause();
  actions.time.seek(frame);
  actions.labels.selectLabel(label);
  actions.view.goToObject(label, frame);
  notify(
    'info',
    `${DOUBT_PREFIX}: ${namesOf([label])}`,
    'Correct it with a stroke or confirm it, then continue.',
  );
}

/** Return the given labels that can be tracked from a frame. */
function present(labels: readonly number[], frame: number): number[] {
  const trackable = trackableLabels(frame);
  return labels.filter((id) => trackable.includes(id));
}

function continueRun(): void {
  const start = state.frame.peek();
  const run = halted.peek();
  const stop = run?.stop ?? (state.sequence.peek()?.frames ?? 1) - 1;
  const doubtful = unsure.peek();
  const wanted = doubtful.length > 0 ? doubtful : [state.activeLabel.peek()];
  const labels = present(run?.labels ?? wanted, start);
  if (labels.length === 0 || start === stop) {
    notify('info', 'Nothing to track in this frame', 'Paint the object in this frame first.');
    return;
  }
  const how = stopped ?? { stop_unsure: doubtful.length > 0 };
  actions.tracking.track({ ...how, labels, start, stop });
}

async function acceptFrame(): Promise<void> {
  const path = openPath(`frames/${state.frame.peek()}/accept`);
  const labels = unsure.peek();
  if (labels.length === 0) return;
  await attempt('The labels were not confirmed', () => api('POST', path, { labels }));
}

/** A stretch of frames that a label is doubtful in: judged, or tracked again, in one press. */
export interface Stretch {
  readonly labels: readonly number[];
  /** Its first and last frame. */
  readonly start: number;
  readonly stop: number;
}

type Rows = ReadonlyMap<number, TimelineRow>;

/** The doubtful frames round `frame`, or beside it where it is sure; null when there are none. */
export function stretchAt(rows: Rows, frame: number, frames: number): Stretch | null {
  for (const seed of [frame, frame + 1, frame - 1]) {
    if (seed < 0 || seed >= frames) continue;
    const labels = [...rows.keys()].filter((id) => doubtful(rows, id, seed));
    if (labels.length === 0) continue;
    const any = (at: number): boolean => labels.some((id) => doubtful(rows, id, at));
    let [start, stop] = [seed, seed];
    while (start > 0 && any(start - 1)) start -= 1;
    while (stop < frames - 1 && any(stop + 1)) stop += 1;
    return { labels, start, stop };
  }
  return null;
}

function doubtful(rows: Rows, id: number, frame: number): boolean {
  const row = rows.get(id);
  return row !== undefined && wantsLook(cellKind(row, frame));
}

/** Return the run that tracks a stretch again, from the sure frame before it, or else after it. */
export function runOver({ labels, start, stop }: Stretch, rows: Rows): Stretch | null {
  for (const [from, to] of [[start - 1, stop], [stop + 1, start]] as const) {
    const sureLabels = labels.filter(
      (id) => hasPoints(rows.get(id), from) && !doubtful(rows, id, from),
    );
    if (sureLabels.length > 0) return { labels: sureLabels, start: from, stop: to };
  } // prettier-ignore
  return null;
}

/** The stretch at the frame at which time stands. */
export const stretch: ReadonlySignal<Stretch | null> = computed(() => {
  const { rows } = state.timeline.value;
  if (state.playing.value || rows.size === 0) return null;
  return stretchAt(rows, state.frame.value, state.sequence.value?.frames ?? 0);
});

async function judge(what: 'accept' | 'clear', failed: string): Promise<void> {
  const found = stretch.peek();
  if (found) await attempt(failed, () => api('POST', openPath(what), found));
}

function trackStretch(): void {
  const found = stretch.peek();
  if (!found) return;
  const run = runOver(found, state.timeline.peek().rows);
  if (run) actions.tracking.track({ ...run, labels: [...run.labels], continue_lost: true });
  else notify('info', 'Nothing to track from', 'Paint the object in a frame next to the range.');
}

export const reviewActions = {
  tracking: {
    acceptFrame,
    continueRun,
    acceptStretch: () => judge('accept', 'The range was not confirmed'),
    clearStretch: () => judge('clear', 'The range was not cleared'),
    trackStretch,
  },
} satisfies ActionParts;
