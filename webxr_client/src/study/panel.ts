/** The task of a study in the headset: its name and text, the time left, and its button. */
import { actions } from '../store/actions';
import { watch } from '../store/watch';
import { lines } from '../xr/drawing/lines';
import { SIZES } from '../xr/drawing/sizes';
import { INK, type Ui } from '../xr/drawing/ui';
import { Panel } from '../xr/panels/panel';
import { Row } from '../xr/panels/timeline-tracking';
import { finish } from './session';
import { activeStep, finishing, secondsLeft, timeLeft, wordsOf } from './step';

/** Ems: tops of the title, of the text, and of the lowest row; width of the button. */
const [TITLE, TEXT, FOOT, WIDE] = [0.4, 2.2, 10.4, 8];
/** Letters of a line, and lines of text that there is room for. */
const [LETTERS, MOST_LINES] = [50, 5];
const LEAVE = 'Leave VR';

function wordsNow(): readonly [title: string, text: string, button: string] {
  const step = activeStep.peek()!;
  const goesOn = step.condition?.device === 'headset' && step.kind !== 'questionnaire';
  if (goesOn || step.kind === 'pause') return wordsOf(step);
  return ['Done in VR', 'Leave VR, take off the headset, and continue at the desk.', LEAVE];
}

export class StudyPanel extends Panel {
  private readonly unsubscribe = watch([activeStep, secondsLeft, finishing], this.touch);

  constructor() {
    super({ width: 0.62, height: 0.3, pixelsPerMetre: 1700, em: SIZES.check.em }, 98);
  }

  override dispose(): void {
    this.unsubscribe();
    super.dispose();
  }

  protected override draw(ui: Ui): void {
    const { em, width, height } = ui;
    const [title, text, button] = wordsNow();
    ui.area({ name: 'move', x: 0, y: 0, w: width, h: height, moves: true, plain: true });
    new Row(ui, TITLE * em).drawText(title);
    const shown = lines(text, LETTERS).slice(0, MOST_LINES).join(' ');
    new Row(ui, TEXT * em, LETTERS).drawText(shown, INK.quiet);
    const foot = new Row(ui, FOOT * em);
    const act = button === LEAVE ? () => actions.page.exitVR() : () => finish([]);
    const look = { text: button, strong: true };
    if (button && !finishing.peek()) foot.button(WIDE, look, () => void act());
    foot.drawText(timeLeft());
  }
}
