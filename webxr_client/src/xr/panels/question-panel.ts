/** Question of a stopped run, in view: accept its result, or correct it, and continue. */
import { halted, stretch, unsure } from '../../engine/review';
import { canReview, state, trackingJob } from '../../store/state';
import { follow, watch } from '../../store/watch';
import { Panel } from './panel';
import { SIZES } from '../drawing/sizes';
import { questionOpen, drawDoubt, drawMended, Row } from './timeline-tracking';
import type { Ui } from '../drawing/ui';

/** Ems: the text, the answers, and the button below them. */
const [TEXT_TOP, ANSWERS_TOP, LATER_TOP] = [0.2, 4, 6.6];
/** Letters of a line of words. */
const LETTERS = 32;

export class QuestionPanel extends Panel {
  /** The run that was answered with "Later". */
  private later: object | null = null;
  private readonly unsubscribe: () => void;

  /** `lay`: bring it before the eyes, once for each question. */
  constructor(lay: () => void) {
    super({ width: 0.445, height: 0.204, pixelsPerMetre: 2000, em: SIZES.question.em }, 98);
    this.mesh.visible = false;
    const redraw = watch([unsure, stretch, halted, canReview, state.palette], this.touch);
    const ask = follow(() => {
      const run = halted.value;
      const isAtDoubt = run !== null && (unsure.value.length > 0 || run.at === state.frame.value);
      const asks = isAtDoubt && run !== this.later && trackingJob.value === null;
      if (asks && !this.mesh.visible) lay();
      this.mesh.visible = questionOpen.value = asks;
      this.touch();
    });
    this.unsubscribe = () => {
      redraw();
      ask();
      questionOpen.value = false;
    };
  }

  override dispose(): void {
    this.unsubscribe();
    super.dispose();
  }

  protected override draw(ui: Ui): void {
    const { em } = ui;
    const textRow = new Row(ui, em * TEXT_TOP, LETTERS);
    const [answerRow, laterRow] = [new Row(ui, em * ANSWERS_TOP), new Row(ui, em * LATER_TOP)];
    laterRow.button(6.5, { text: 'Later', strong: true }, () => {
      this.later = halted.peek();
      this.mesh.visible = questionOpen.value = false;
    });
    if (unsure.peek().length > 0) drawDoubt(textRow, answerRow, laterRow);
    else if (halted.peek()) drawMended(textRow, laterRow);
  }
}
