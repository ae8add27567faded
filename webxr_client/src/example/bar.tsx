/** Bar over the canvas, at the bottom: the question of the place in doubt, and applying the prediction. */
import type { Place as Question } from '../protocol/values';
import { signal } from '@preact/signals';
import { Icon } from '../common/icons';
import { percent, plural } from '../common/format';
import { Button, Slider, Swatch } from '../panels/parts/controls';
import { PopoverButton } from '../panels/parts/popover';
import { RadioGroup, type RadioOption } from '../panels/parts/radio-group';
import { frameRange, ordered } from '../store/range';
import { canEdit, state } from '../store/state';
import { coloursOf } from './model';
import { answerable, answerDoubt, answered, applyPrediction, isRequesting, classifier, classifiers, closeExample, exampleOpen, leaveQuestion, makeClassifier, predicted, question, skipDoubt, starts, takeBackAnswer, toggleExample } from './store'; // prettier-ignore
import { Summary } from './summary';

export function ExampleButton() {
  return (
    <Button icon="example" label="By example" class="example-button" tip="Paint examples of each class; a classifier labels the rest" pressed={exampleOpen.value} onClick={toggleExample} />
  ); // prettier-ignore
}

export function ExampleBar() {
  if (!exampleOpen.value || !state.sequence.value) return null;
  return (
    <section class="example-bar bar card" aria-label="Label by example">
      <div class="example-row line start">
        <Icon name="example" />
        {question.value ? <QuestionBar place={question.value} /> : <Predicted />}
      </div>
    </section>
  ); // prettier-ignore
}

function Begin() {
  if (classifiers.value === null) return <span class="soft">Loading classifiers…</span>;
  return (
    <>
      <span>Paint examples of at least two classes.</span>
      <Button label="Learn from painted points" kind="primary" disabled={!canEdit.value || isRequesting.value} onClick={() => void makeClassifier()} />
      {starts.value.length > 0 && (
        <Button label={`Start from ${plural(starts.value.length, 'labelled recording')}`} kind="outlined" tip="Their labels teach, too; the more you paint, the less they count" disabled={!canEdit.value || isRequesting.value} onClick={() => void makeClassifier(starts.value)} />
      )}
    </>
  ); // prettier-ignore
}

function Predicted() {
  return (
    <>
      <div class="example-parts line wrap grow">
        {classifier.value ? <><PredictionSummary /><Doubts label="Next doubt" tip="Go to the doubtful place that teaches the classifier most" disabled={isRequesting.value} /><Apply /></> : <Begin />}
      </div>
      <Button icon="close" tip="Close: hides the prediction, keeps the labels" small onClick={closeExample} />
    </>
  ); // prettier-ignore
}

/** Buttons to the next doubt, and back to the last one. */
function Doubts({ label, tip, disabled }: { label: string; tip: string; disabled: boolean }) {
  return (
    <>
      <Button label={label} keys=";" kind="outlined" tip={tip} disabled={disabled} onClick={() => void skipDoubt()} />
      {answered.value.length > 0 && (
        <Button icon="undo" label="Undo answer" keys="Backspace" kind="outlined" tip="Take back the last answer, and ask again" onClick={takeBackAnswer} />
      )}
    </>
  ); // prettier-ignore
}

function PredictionSummary() {
  const prediction = predicted.value;
  if (prediction && !prediction.kind.some(Boolean))
    return <span class="soft">Paint a second class: a classifier needs at least two</span>;
  return (
    <span class="example-told line" role="status">
      {prediction && <span class="number">{plural(prediction.kind.length, 'point')}</span>}
      {prediction && state.sequence.value?.large && (
        <span class="soft">near the centre of the view</span>
      )}
      {isRequesting.value && <span class="spinner small" aria-label="Predicting" />}
    </span>
  );
}

function QuestionBar({ place }: { place: Question }) {
  const { classes } = classifier.value!;
  const colours = coloursOf(classes, state.palette.value);
  const likely = (name: string): boolean => place.classes.includes(name);
  return (
    <>
      <div class="example-parts line wrap grow" role="group" aria-label="A place in doubt">
        <span>Which class is the outlined piece ({plural(place.points, 'point')})?</span>
        {classes.map((name, k) => (
          <button key={name} type="button" class={`button${likely(name) ? ' outlined' : ''}`} data-keys={name === place.classes[0] ? 'Enter' : undefined} data-tip={`Label them as ${name}`} disabled={!answerable.value} onClick={() => answerDoubt(name)}>
            <Swatch color={colours[k]!} /> <span class="button-label">{name}</span>
            {k < 9 && <span class="kbd">{k + 1}</span>}
          </button>
        ))}
        <button type="button" class="button outlined" data-tip="Leave them without a label, and do not ask again" disabled={!answerable.value} onClick={() => answerDoubt(null)}>
          <span class="button-label">None of these</span> <span class="kbd">0</span>
        </button>
        <Doubts label="Skip" tip="Leave this place open, and do not ask about it again" disabled={false} />
      </div>
      <Button icon="close" small tip="Stop asking" onClick={leaveQuestion} />
    </>
  ); // prettier-ignore
}

type Reach = 'frame' | 'range' | 'all';

const applyOpen = signal(false);
/** Chosen lowest confidence; null: the default of the classifier. */
const chosenLeast = signal<number | null>(null);
const reach = signal<Reach>('frame');

function Apply() {
  return (
    <PopoverButton
      open={applyOpen}
      button={{ label: 'Turn into labels…' }}
      kind="primary"
      tip="Label points as predicted: in this frame or in many"
      disabled={!canEdit.value}
      label="Turn the prediction into labels"
      class="form"
    >
      <ApplyForm />
    </PopoverButton>
  );
}

/** Frames as the server reads them. */
function framesOf(kind: Reach): string {
  const frame = state.frame.peek();
  if (kind === 'all') return '';
  if (kind === 'frame' || !frameRange.peek()) return `${frame}:${frame + 1}`;
  const [first, last] = ordered(frameRange.peek()!);
  return `${first}:${last + 1}`;
}

function ApplyForm() {
  const all = state.sequence.value?.frames ?? 1;
  const choices: readonly RadioOption<Reach>[] = [
    { value: 'frame', label: 'This frame' },
    { value: 'range', label: 'Selected range', disabled: frameRange.value === null },
    { value: 'all', label: `All ${plural(all, 'frame')}` },
  ];
  const least = chosenLeast.value ?? classifier.value?.above ?? 0;
  const submit = (event: Event): void => {
    event.preventDefault();
    applyOpen.value = false;
    void applyPrediction(framesOf(reach.peek()), least);
  };
  return (
    <form onSubmit={submit}>
      <h2>Turn the prediction into labels</h2>
      <RadioGroup label="Frames" options={choices} value={reach.value} onChoose={(chosen) => (reach.value = chosen)} />
      <Slider label="Minimum confidence" value={least} min={0} max={1} shown={percent(least)} tip="Points with a lower confidence stay unlabelled" onInput={(value) => (chosenLeast.value = value)} />
      <Summary least={least} whole={reach.value === 'frame'} />
      <div class="form-end">
        <Button label="Cancel" onClick={() => (applyOpen.value = false)} />
        <button type="submit" class="button primary" disabled={!canEdit.value}>Label the points</button>
      </div>
    </form>
  ); // prettier-ignore
}
