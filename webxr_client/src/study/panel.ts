/** The task of a study in the headset: its name and text, the time left, and its button. */
import { actions } from '../store/actions';
import { watch } from '../store/watch';
import { lines } from '../xr/drawing/lines';
import { SIZES } from '../xr/drawing/sizes';
import { INK, type Ui } from '../xr/drawing/ui';
import { Panel } from '../xr/panels/panel';
import { finish } from './session';
import { activeStep, canFinish, finishing, minutes, PAUSED, secondsLeft } from './step';

/** Ems: padding, middles of the first lines of title and text, a line's height, and the button. */
const [PAD, TITLE, TEXT, ROW, WIDE, HIGH] = [0.8, 1.6, 3.4, 1.5, 8, 2.2];
/** Lines of text that there is room for, and letters of a line. */
const [MOST_LINES, LETTERS] = [4, 50];
const LEAVE = 'Leave VR';
const TAKE_OFF = 'Leave VR, take off the headset, and continue at the desk.';

/** Return title, text and the button's words; empty: no button. */
function wordsNow(): [title: string, text: string, button: string] {
  const step = activeStep.peek()!;
  const { kind, condition, task } = step;
  if (kind === 'pause') return ['Paused', PAUSED, ''];
  if (condition?.device !== 'headset' || kind === 'questionnaire')
    return ['Done in VR', TAKE_OFF, LEAVE];
  const title = `${kind === 'practice' ? 'Practice: ' : ''}${task?.name ?? 'Instructions'}`;
  const button = kind === 'instructions' ? 'Begin' : canFinish(step) ? 'Done' : '';
  return [title, step.text, finishing.peek() ? '' : button];
}

export class StudyPanel extends Panel {
  private readonly unsubscribe = watch([activeStep, secondsLeft, finishing], this.touch);

  constructor() {
    super({ width: 0.62, height: 0.24, pixelsPerMetre: 1700, em: SIZES.check.em }, 98);
  }

  override dispose(): void {
    this.unsubscribe();
    super.dispose();
  }

  protected override draw(ui: Ui): void {
    const { em, width, height } = ui;
    const [pad, inner, foot] = [PAD * em, width - 2 * PAD * em, height - em * (HIGH + PAD)];
    const [title, text, button] = wordsNow();
    ui.area({ name: 'move', x: 0, y: 0, w: width, h: height, moves: true, plain: true });
    ui.text(title, pad, em * TITLE, { weight: 650, size: 1.2, width: inner });
    lines(text, LETTERS)
      .slice(0, MOST_LINES)
      .forEach((line, i) =>
        ui.text(line, pad, em * (TEXT + ROW * i), { color: INK.quiet, width: inner }),
      );
    const left = secondsLeft.peek();
    if (left !== null) ui.text(`${minutes(left)} left`, pad, foot + (em * HIGH) / 2);
    if (!button) return;
    const act = button === LEAVE ? () => actions.page.exitVR() : () => finish([]);
    const look = { text: button, strong: true };
    ui.button(width - pad - WIDE * em, foot, WIDE * em, HIGH * em, look, () => void act());
  }
}
