/** The task of a study in the tool bar: its name, the time left, and the button that ends it. */
import type { IconName } from '../common/icons';
import { Button } from '../panels/parts/controls';
import { finish } from './session';
import { activeStep, canFinish, finishing, minutes, secondsLeft } from './step';

export function StudyBar() {
  const step = activeStep.value;
  const left = secondsLeft.value;
  if (!step?.task) return null;
  return (
    <div class="line" role="group" aria-label="Task">
      {step.kind === 'practice' && <span class="pill">Practice</span>}
      <strong class="title" data-tip={step.text}>
        {step.task.name}
      </strong>
      <span class="soft small number">
        Step {step.number + 1} of {step.count}
      </span>
      {left !== null && (
        <span class="number" role="timer">
          {minutes(left)} left
        </span>
      )}
      {canFinish(step) && <NextButton icon="check" label="Done" />}
    </div>
  );
}

/** The button that finishes the step. */
export function NextButton(look: { label: string; icon?: IconName }) {
  const next = (): void => void finish([]);
  return <Button {...look} kind="primary" disabled={finishing.value} onClick={next} />;
}
