/** The step of a participant: its state for the page's cards, the tool bar and the headset. */
import { signal } from '@preact/signals';
import type { StudyStep } from '../protocol/values';

export const activeStep = signal<StudyStep | null>(null);
/** Whole seconds until the time limit; null: none. */
export const secondsLeft = signal<number | null>(null);
/** The step is being finished. */
export const finishing = signal(false);

/** Words of a paused step. */
export const PAUSED = 'The study continues in a moment. Your work is kept.';

/** Return whether labels are painted in a step. */
export function isTask({ kind }: StudyStep): boolean {
  return kind === 'practice' || kind === 'task';
}

/** Return whether a step is done in a headset. */
export function isWorn(step: StudyStep): boolean {
  const reads = step.kind === 'instructions' && step.task !== null;
  return step.condition?.device === 'headset' && (isTask(step) || reads);
}

/** Return whether the participant ends a task by a button. */
export function canFinish(step: StudyStep): boolean {
  return isTask(step) && (step.kind === 'practice' || step.task?.stop === 'button');
}

/** 83 → "1:23". */
export function minutes(seconds: number): string {
  return `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, '0')}`;
}
