/** Page of the palette for label by example: what is predicted, its doubts, applying it. */
import type { Place as Question } from '../../../protocol/values';
import { coloursOf, type Tally, talliesOf } from '../../../example/model';
import { answerable, answerDoubt, applyPrediction, isRequesting, classifier, classifiers, closeExample, exampleOpen, makeClassifier, natural, openExample, predicted, question, skipDoubt } from '../../../example/store'; // prettier-ignore
import { percent, plural } from '../../../common/format';
import { canEdit, state } from '../../../store/state';
import { INK, type Ui } from '../../drawing/ui';
import { VIEWER } from './rows';

/** Signals that the page shows. */
export const EXAMPLE = [
  exampleOpen, classifier, classifiers, predicted, question, natural, isRequesting, canEdit,
  answerable,
] as const; // prettier-ignore

const PITCH = 2.6;
const HOW = ['Paint examples of each class.', 'A classifier labels the rest.'];

export function drawExample(ui: Ui, x: number, top: number, inner: number): void {
  const { em } = ui;
  const line = (row: number): number => top + em * PITCH * row;
  ui.check(x, line(0), inner, em * 2.2, 'Show the prediction', exampleOpen.peek(), (on) =>
    on ? void openExample() : closeExample(),
  );
  if (!exampleOpen.peek() || !classifier.peek()) {
    const wanting = lacks();
    const words = exampleOpen.peek() && wanting ? [wanting] : HOW;
    words.forEach((text, i) => {
      ui.text(text, x + em * 0.4, line(1) + em * (1.2 + 1.6 * i), { color: INK.quiet });
    });
    const disabled = !exampleOpen.peek() || wanting !== '';
    ui.button(x, line(3), inner - em * 0.2, em * 2.2,
      { icon: 'example', text: 'Learn from painted points', on: true, disabled },
      () => void makeClassifier()); // prettier-ignore
    return;
  }
  ui.text(statusText(), x + em * 0.4, line(1) + em * 1.2, { color: INK.quiet });
  ui.check(x, line(2), inner, em * 2.2, 'Natural colours', natural.peek(), (on) => {
    natural.value = on;
  });
  ui.button(x, line(3), inner - em * 0.2, em * 2.2,
    { icon: 'target', text: question.peek() ? 'Skip' : 'Next doubt', strong: true, align: 'left' },
    () => void skipDoubt()); // prettier-ignore
  const place = question.peek();
  if (place) drawAnswers(ui, x, line(4), inner, place);
  const ready = canEdit.peek() && tally()?.points !== 0;
  ui.button(x, line(5), inner - em * 0.2, em * 2.2,
    { icon: 'check', text: 'Apply to this frame', strong: true, align: 'left', disabled: !ready },
    applyToFrame); // prettier-ignore
}

function applyToFrame(): void {
  const frame = state.frame.peek();
  void applyPrediction(`${frame}:${frame + 1}`, 0);
}

/** Return the reason why nothing can be learned yet, or "". */
function lacks(): string {
  if (!canEdit.peek()) return VIEWER;
  if (isRequesting.peek() || classifiers.peek() === null) return 'Waiting for the server…';
  const painted = state.palette.peek().filter(({ id }) => (state.counts.peek().get(id) ?? 0) > 0);
  return painted.length > 1 ? '' : 'Paint points of two labels first.';
}

/** Points that are predicted in the frame. */
function tally(): Tally | undefined {
  const prediction = predicted.peek();
  return prediction ? talliesOf(prediction, classifier.peek()!.classes.length)[0] : undefined;
}

function statusText(): string {
  if (!canEdit.peek()) return VIEWER;
  if (question.peek()) return 'Point at the piece and push the pad, or:';
  const { points = 0, unsure = 0 } = tally() ?? {};
  if (isRequesting.peek()) return 'Predicting…';
  if (points === 0) return 'No prediction in this frame yet';
  return `${plural(points, 'point')}, ${percent(unsure / points)} in doubt`;
}

/** Three buttons: the points that pulse white are of one of two classes, or of none. */
function drawAnswers(ui: Ui, x: number, y: number, inner: number, place: Question): void {
  const { em } = ui;
  const colours = coloursOf(place.classes, state.palette.peek());
  const third = inner / 3;
  [...place.classes, null].forEach((choice, k) => {
    const look = choice === null ? { text: 'Neither' } : { text: choice, swatch: colours[k]! };
    ui.button(x + k * third, y, third - em * 0.2, em * 2.2,
      { ...look, strong: true, align: 'left', disabled: !answerable.peek() },
      () => answerDoubt(choice)); // prettier-ignore
  });
}
