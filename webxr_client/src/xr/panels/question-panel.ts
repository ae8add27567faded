/** Question in view: about a stopped run, or the next step with found people. */
import { leavePeople, peopleOffer, peopleStep, type StepOffer } from '../../engine/find-people';
import { halted, stretch, unsure } from '../../engine/review';
import { canReview, state, trackingJob } from '../../store/state';
import { follow, watch } from '../../store/watch';
import { Panel } from './panel';
import { SIZES } from '../drawing/sizes';
import { questionOpen, drawDoubt, drawMended, Row } from './timeline-tracking';
import { INK, type Ui } from '../drawing/ui';

/** Ems: the text, the answers, and the button below them. */
const [TEXT_TOP, ANSWERS_TOP, LATER_TOP] = [0.2, 4, 6.6];
/** Number of people that the panel has room to name. */
const MOST_NAMED = 3;
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
    const redraw = watch(
      [unsure, stretch, halted, canReview, state.palette, peopleOffer],
      this.touch,
    );
    const ask = follow(() => {
      const run = halted.value;
      const isAtDoubt = run !== null && (unsure.value.length > 0 || run.at === state.frame.value);
      const asks = isAtDoubt && run !== this.later && trackingJob.value === null;
      const visible = asks || peopleOffer.value?.main != null;
      if (visible && !this.mesh.visible) lay();
      this.mesh.visible = visible;
      questionOpen.value = asks;
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
    const offer = peopleOffer.peek();
    if (offer?.main) {
      drawPeople(ui, textRow, offer);
      return;
    }
    const [answerRow, laterRow] = [new Row(ui, em * ANSWERS_TOP), new Row(ui, em * LATER_TOP)];
    laterRow.button(6.5, { text: 'Later', strong: true }, () => {
      this.later = halted.peek();
      this.mesh.visible = questionOpen.value = false;
    });
    if (unsure.peek().length > 0) drawDoubt(textRow, answerRow, laterRow);
    else if (halted.peek()) drawMended(textRow, laterRow);
  }
}

/** The found people by name and colour, the next step, and the way to leave it out. */
function drawPeople(ui: Ui, textRow: Row, { text, main, leave }: StepOffer): void {
  const { em } = ui;
  textRow.drawText(text);
  const people = peopleStep.peek()?.people.slice(0, MOST_NAMED) ?? [];
  const wide = (ui.width - em) / MOST_NAMED;
  people.forEach(({ name, color }, k) => {
    ui.box(em * 0.8 + k * wide, em * 2.4, em, em, color, 0.3);
    ui.text(name, em * 2.2 + k * wide, em * 2.9, { color: INK.quiet, width: wide - em * 2 });
  });
  const row = new Row(ui, em * ANSWERS_TOP);
  row.button(8, { text: leave, strong: true }, leavePeople);
  row.button(9, { ...main!, on: true }, main!.run);
}
