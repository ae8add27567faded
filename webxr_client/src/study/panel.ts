/** The task of a study in the headset: its name and text, the time left, and its button. */
import { actions } from '../store/actions';
import { watch } from '../store/watch';
import { SIZES } from '../xr/drawing/sizes';
import { INK, type Ui } from '../xr/drawing/ui';
import { Panel } from '../xr/panels/panel';
import { activeStep, canFinish, finish, finishing, minutes, secondsLeft } from './step';

/** Ems: padding, first line, from one line of the text to the next, and the button. */
const [PAD, TITLE, ROW, WIDE, HIGH] = [0.8, 1.6, 1.5, 8, 2.2];
/** Lines of text that there is room for. */
const MOST_LINES = 4;
const LEAVE = 'Leave VR';
const TAKE_OFF = 'Leave VR, take off the headset, and continue at the desk.';
const PAUSED = 'The study continues in a moment. Your work is kept.';

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
    const step = activeStep.peek();
    if (!step) return;
    const [pad, inner] = [PAD * em, width - 2 * PAD * em];
    const paused = step.kind === 'pause';
    const works = step.condition?.device === 'headset' && !paused && step.kind !== 'questionnaire';
    const name = `${step.kind === 'practice' ? 'Practice: ' : ''}${step.task?.name ?? 'Instructions'}`;
    const title = works ? name : paused ? 'Paused' : 'Done in VR';
    const text = works ? step.text : paused ? PAUSED : TAKE_OFF;
    ui.area({ name: 'move', x: 0, y: 0, w: width, h: height, moves: true, plain: true });
    ui.text(title, pad, em * TITLE, { weight: 650, size: 1.2, width: inner });
    wrap(ui, text, inner).forEach((line, i) =>
      ui.text(line, pad, em * (TITLE + 1.8 + ROW * i), { color: INK.quiet }),
    );
    const finishes = works && !finishing.peek();
    const done = finishes && canFinish(step) ? 'Done' : '';
    const next = finishes && step.kind === 'instructions' ? 'Begin' : done;
    this.drawFoot(ui, pad, height - em * (HIGH + PAD), works || paused ? next : LEAVE);
  }

  private drawFoot(ui: Ui, pad: number, y: number, text: string): void {
    const { em, width } = ui;
    const left = secondsLeft.peek();
    if (left !== null) ui.text(`${minutes(left)} left`, pad, y + (em * HIGH) / 2);
    const act = text === LEAVE ? () => actions.page.exitVR() : () => finish([]);
    const look = { text, strong: true };
    if (text) ui.button(width - pad - WIDE * em, y, WIDE * em, HIGH * em, look, () => void act());
  }
}

/** Return the first lines of a text, broken between words. */
function wrap({ pen, em }: Ui, text: string, width: number): string[] {
  const lines = [''];
  pen.font = pen.font.replace(/[\d.]+px/, `${em}px`);
  for (const word of text.split(/\s+/).filter(Boolean)) {
    const longer = `${lines.at(-1)!} ${word}`.trim();
    if (pen.measureText(longer).width <= width) lines[lines.length - 1] = longer;
    else lines.push(word);
  }
  return lines.slice(0, MOST_LINES);
}
