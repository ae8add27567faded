/** The step of a participant: its state for the page's cards, the tool bar and the headset. */
import { signal } from '@preact/signals';
import type { StudyStep } from '../protocol/values';

export const activeStep = signal<StudyStep | null>(null);
/** Whole seconds until the time limit; null: none. */
export const secondsLeft = signal<number | null>(null);
/** The step is being finished. */
export const finishing = signal(false);

/** Return whether labels are painted in a step. */
export function isTask({ kind }: StudyStep): boolean {
  return kind === 'practice' || kind === 'task';
}

/** Return whether a step is done in a headset. */
export function isWorn(step: StudyStep): boolean {
  const reads = step.kind === 'instructions' && step.task !== null;
  return step.condition?.device === 'headset' && (isTask(step) || reads);
}

/** Return title and text of a step, and the words of the button that ends it; empty: no button. */
export function wordsOf(step: StudyStep): [title: string, text: string, button: string] {
  const { kind, task, text } = step;
  if (kind === 'consent') return ['Before you begin', text, 'I agree'];
  if (kind === 'pause')
    return ['Paused', 'The study continues in a moment. Your work is kept.', ''];
  if (kind === 'done') return ['Thank you', 'The study is finished. You can close this page.', ''];
  const title = task?.practice ? 'Practice' : (task?.name ?? 'Instructions');
  if (kind === 'instructions') return [title, text, 'Begin'];
  return [title, text, kind === 'practice' || task?.stop === 'button' ? 'Done' : ''];
}

/** 83 → "1:23 left"; empty without a time limit. */
export function timeLeft(): string {
  const seconds = secondsLeft.value;
  if (seconds === null) return '';
  return `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, '0')} left`;
}
