/** Places of recordings: the marked one, the one that is pointed at, and the way to one. */
import { signal } from '@preact/signals';
import { actions } from '../store/actions';
import { state } from '../store/state';
import type { Place } from './model';

/** The place that the camera flew to, source coordinates; it is marked. */
export const marked = signal<Place | null>(null);
/** Metres from which the marked place is looked at; 0: the view stays as far, within limits. */
export const markedFrom = signal(0);
/** Rise of the eyes over such a place for a metre along. */
export const RISE = 0.6;
/** Receiver of the place of the next click; null: a click uses the tool. */
export const pointing = signal<((place: Place) => void) | null>(null);

/** Returns the point in the middle of the picture, source coordinates; set by `Flight`. */
export const looking: { at: () => Place | null } = { at: () => null };

interface Goal {
  readonly sequence: string;
  readonly frame: number;
  readonly place: Place | null;
}

/** A place to go to once its recording is open. */
const goal = signal<Goal | null>(null);

/** Go to a place in a frame of the open recording. */
export function visit(frame: number | null, place: Place | null): void {
  if (frame !== null) {
    actions.time.pause();
    actions.time.seek(frame);
  }
  markedFrom.value = 0;
  marked.value = place && [...place];
}

/** Go to a frame of a recording, which is opened first, and fly to the place in it. */
export function goTo(sequence: string, frame: number, place: Place | null = null): void {
  goal.value = { sequence, frame, place };
  if (state.sequence.peek()?.id !== sequence) actions.recordings.openSequence(sequence);
}

/** Fly to the goal once its recording has a view: a flight before that would be undone. */
export function arrive(): void {
  const { value } = goal;
  const isArrived =
    value && state.opening.value === null && state.sequence.value?.id === value.sequence;
  if (!isArrived || !state.framed.value) return;
  queueMicrotask(() => {
    if (goal.peek() !== value || !state.framed.peek()) return;
    goal.value = null;
    visit(value.frame, value.place);
  });
}
