/** Tasks in a checked headset: their texts and results. */
import { computed, signal } from '@preact/signals';
import type { HeadsetTask } from '../protocol/values';
import type { Lesson } from '../xr/input/lessons';

export type TaskName = HeadsetTask['name'];
type Verdict = HeadsetTask['verdict'];

export interface Task {
  readonly name: TaskName;
  /** Short, with its tick. */
  readonly title: string;
  /** The lesson of the button that does it, and where a panel does. */
  readonly lesson?: Lesson;
  readonly otherwise: string;
}

export const TASKS: readonly Task[] = [
  { name: 'play', title: 'Watch it play', otherwise: 'The recording plays for some seconds.' },
  { name: 'felt', title: 'Feel a pulse', otherwise: 'Press “Pulse”. Does the controller shake?' },
  { name: 'paint', title: 'Paint', lesson: 'paint', otherwise: 'Hold the brush in the points and press.' },
  { name: 'erase', title: 'Erase', lesson: 'erase', otherwise: 'Palette: Tools, Erase. Then paint there.' },
  { name: 'label', title: 'Switch the label', lesson: 'label', otherwise: 'Palette: Labels.' },
  { name: 'undo', title: 'Undo', lesson: 'undo', otherwise: 'Palette: the arrow back.' },
  { name: 'step', title: 'Next frame', lesson: 'step', otherwise: 'Timeline: the arrows.' },
  { name: 'go', title: 'Go there', lesson: 'teleport', otherwise: 'Palette: View, Go there.' },
]; // prettier-ignore

interface Outcome {
  readonly verdict: Verdict;
  /** The person went on without it. */
  readonly left: boolean;
}

const NOTHING: Outcome = { verdict: 'unknown', left: false };

export const outcomes = signal<ReadonlyMap<TaskName, Outcome>>(new Map());

export function outcomeOf(name: TaskName): Outcome {
  return outcomes.value.get(name) ?? NOTHING;
}

/** The first task that is neither done nor left; null: nothing is left to do. */
export const task = computed(
  () =>
    TASKS.find(({ name }) => {
      const { verdict, left } = outcomeOf(name);
      return verdict === 'unknown' && !left;
    }) ?? null,
);

function set(name: TaskName, outcome: Outcome): void {
  outcomes.value = new Map(outcomes.peek()).set(name, outcome);
}

/** Note that a task was done; done once, it works. */
export function tick(name: TaskName): void {
  if (outcomes.peek().get(name)?.verdict !== 'works') set(name, { verdict: 'works', left: false });
}

/** Note the person's word that it does not work. */
export function fail(name: TaskName): void {
  set(name, { verdict: 'fails', left: true });
}

/** Go on without a task. */
export function leave(name: TaskName): void {
  set(name, { verdict: 'unknown', left: true });
}
