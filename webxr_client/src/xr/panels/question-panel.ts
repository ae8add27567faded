/** Question of a stopped run, in view: accept its result, or correct it, and continue. */
import { halted, stretch, unsure } from '../../engine/review';
import { canReview, state, trackingJob } from '../../store/state';
import { follow, watch } from '../../store/watch';
import { Panel } from './panel';
import { SIZES } from '../drawing/sizes';
import { asking, drawDoubt, drawMended, Row } from './timeline-tracking';
import type { Ui } from '../drawing/ui';

/** Ems: the text, the answers, and the button below them. */
const [WORDS_AT, ANSWERS_AT, ONWARD_AT] = [0.2, 4, 6.6];
/** Letters of a line of words. */
const LETTERS = 32;

export class QuestionPanel extends Panel {
  /** The run that was answered with "Later". */
  private later: object | null = null;
  private readonly unfollow: () => void;

  /** `lay`: bring it before the eyes, once for each question. */
  constructor(lay: () => void) {
    super({ width: 0.445, height: 0.204, pixelsPerMetre: 2000, em: SIZES.question.em }, 98);
    this.mesh.visible = false;
    const redraw = watch([unsure, stretch, halted, canReview, state.palette], this.touch);
    const ask = follow(() => {
      const run = halted.value;
      const here = run !== null && (unsure.value.length > 0 || run.at === state.frame.value);
      const asks = here && run !== this.later && trackingJob.value === null;
      if (asks && !this.mesh.visible) lay();
      this.mesh.visible = asking.value = asks;
      this.touch();
    });
    this.unfollow = () => {
      redraw();
      ask();
      asking.value = false;
    };
  }

  override dispose(): void {
    this.unfollow();
    super.dispose();
  }

  protected override draw(ui: Ui): void {
    const { em } = ui;
    const words = new Row(ui, em * WORDS_AT, LETTERS);
    const [answers, onward] = [new Row(ui, em * ANSWERS_AT), new Row(ui, em * ONWARD_AT)];
    onward.button(6.5, { text: 'Later', strong: true }, () => {
      this.later = halted.peek();
      this.mesh.visible = asking.value = false;
    });
    if (unsure.peek().length > 0) drawDoubt(words, answers, onward);
    else if (halted.peek()) drawMended(words, onward);
  }
}
