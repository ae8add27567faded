/** Bar over the canvas, at the bottom: prediction of the frame, its doubts, and applying it. */
import { signal } from '@preact/signals';
import { Icon } from '../common/icons';
import { percent, plural } from '../common/format';
import { Button, Slider, Swatch } from '../panels/parts/controls';
import { PopoverButton } from '../panels/parts/popover';
import { RadioGroup, type RadioOption } from '../panels/parts/radio-group';
import { frameRange, ordered } from '../store/range';
import { canEdit, canManage, state } from '../store/state';
import { coloursOf, type Question, type Scope, type Shows } from './model';
import {
  answerable,
  answerDoubt,
  applyPrediction,
  asking,
  chooseClassifier,
  classifier,
  classifiers,
  closeExample,
  deleteClassifier,
  exampleOpen,
  leaveQuestion,
  makeClassifier,
  nextDoubt,
  predicted,
  question,
  scope,
  shows,
  teachHere,
  toggleExample,
} from './store';

export function ExampleButton() {
  return (
    <Button icon="example" label="By example" class="example-button" tip="Paint examples of each class; a classifier labels the rest" pressed={exampleOpen.value} onClick={toggleExample} />
  ); // prettier-ignore
}

export function ExampleBar() {
  if (!exampleOpen.value || !state.sequence.value) return null;
  return (
    <section class="example-bar bar card" aria-label="Label by example">
      {question.value && <Asked place={question.value} />}
      <div class="example-row line start">
        <Icon name="example" />
        <div class="example-parts line wrap grow">{classifier.value ? <Predicted /> : <Begin />}</div>
        <Button icon="close" tip="Close: hides the prediction, keeps the labels" small onClick={closeExample} />
      </div>
    </section>
  ); // prettier-ignore
}

function Begin() {
  if (classifiers.value === null) return <span class="soft">Loading classifiers…</span>;
  return (
    <>
      <span>Paint examples of at least two classes.</span>
      <Button label="Learn from painted points" kind="primary" disabled={!canEdit.value || asking.value} onClick={() => void makeClassifier()} />
    </>
  ); // prettier-ignore
}

function Predicted() {
  return (
    <>
      <Choice />
      <Told />
      <Look />
      <Button label="Next doubt" keys=";" kind="outlined" tip="Go to the doubtful place that teaches the classifier most" disabled={asking.value && question.value === null} onClick={() => void nextDoubt()} />
      <Apply />
    </>
  ); // prettier-ignore
}

const choiceOpen = signal(false);

/** The classifier, what taught it, and others. */
function Choice() {
  const chosen = classifier.value!;
  const here = state.sequence.value!.id in chosen.taught_by;
  return (
    <>
      <strong class="name">{chosen.name}</strong>
      <PopoverButton open={choiceOpen} icon="more" small tip="Classifier: its examples, other classifiers" label="Classifier" class="form">
        <select class="field" aria-label="Classifier" value={chosen.id} onChange={(event) => chooseClassifier(event.currentTarget.value)}>
          {classifiers.value?.map(({ id, name }) => <option key={id} value={id}>{name}</option>)}
        </select>
        <Classes />
        <Scopes />
        {chosen.score !== null && <p class="soft">Accuracy on held-out examples: {percent(chosen.score)}.</p>}
        {canEdit.value && (
          <div class="form-end">
            {canManage.value && <Button label="Delete" kind="danger" onClick={() => void deleteClassifier()} />}
            <Button label="New classifier" kind="outlined" onClick={() => void makeClassifier()} />
            {!here && <Button label="Teach with this recording" kind="primary" onClick={() => void teachHere()} />}
          </div>
        )}
      </PopoverButton>
    </>
  ); // prettier-ignore
}

const SCOPES: readonly RadioOption<Scope>[] = [
  { value: 'frame', label: 'This frame' },
  { value: 'recording', label: 'Recording' },
  { value: 'workspace', label: 'Workspace' },
];

function Scopes() {
  return (
    <>
      <span class="soft">Search for doubts in</span>
      <RadioGroup label="Search for doubts in" class="segmented" options={SCOPES} value={scope.value} onChoose={(chosen) => (scope.value = chosen)} />
    </>
  ); // prettier-ignore
}

function Classes() {
  const { classes, examples } = classifier.value!;
  const colours = coloursOf(classes, state.palette.value);
  return (
    <ul class="stack">
      {classes.map((name, k) => (
        <li key={name} class="line">
          <Swatch color={colours[k]!} /> {name}
          <span class="soft number">{plural(examples[name] ?? 0, 'example')}</span>
        </li>
      ))}
    </ul>
  );
}

function Told() {
  const told = predicted.value;
  if (told && told.points === 0)
    return <span class="soft">Paint a second class: a classifier needs at least two</span>;
  return (
    <span class="example-told line" role="status">
      {told && <span class="number">{plural(told.points, 'point')}</span>}
      {told && state.sequence.value?.large && <span class="soft">near the centre of the view</span>}
      {told && <span class="soft">{percent(told.unsure / told.points)} in doubt</span>}
      {asking.value && <span class="spinner small" aria-label="Predicting" />}
    </span>
  );
}

const LOOKS: readonly RadioOption<Shows>[] = [
  { value: 'classes', label: 'Classes', tip: 'Predicted class of each point' },
  { value: 'doubt', label: 'Doubt', tip: 'Red: in doubt, green: certain' },
];

function Look() {
  return (
    <RadioGroup label="Show" class="segmented" options={LOOKS} value={shows.value} onChoose={(chosen) => (shows.value = chosen)} />
  ); // prettier-ignore
}

function Asked({ place }: { place: Question }) {
  const [first, second] = place.classes as [string, string];
  const colours = coloursOf(place.classes, state.palette.value);
  const answers = [[first, 'Enter'], [second, 'Shift Enter']] as const; // prettier-ignore
  return (
    <div class="example-row line start" role="group" aria-label="A place in doubt">
      <div class="example-parts line wrap grow">
        <span>Which class is at the ring?</span>
        {answers.map(([name, keys], k) => (
          <button key={name} type="button" class="button outlined" data-keys={keys} data-tip={`Paint it as ${name}`} disabled={!answerable.value} onClick={() => answerDoubt(k as 0 | 1)}>
            <Swatch color={colours[k]!} /> <span class="button-label">{name}</span>
          </button>
        ))}
        <button type="button" class="button outlined" data-keys="Alt Enter" data-tip="Leave these points without a label, and do not ask again" disabled={!answerable.value} onClick={() => answerDoubt('none')}>
          <span class="button-label">None of these</span>
        </button>
        <span class="soft">or paint another class</span>
      </div>
      <Button icon="close" small tip="Skip this question" onClick={leaveQuestion} />
    </div>
  ); // prettier-ignore
}

type Reach = 'frame' | 'range' | 'all';

const applyOpen = signal(false);
const least = signal(0);
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
  const submit = (event: Event): void => {
    event.preventDefault();
    applyOpen.value = false;
    void applyPrediction(framesOf(reach.peek()), least.peek());
  };
  return (
    <form onSubmit={submit}>
      <h2>Turn the prediction into labels</h2>
      <RadioGroup label="Frames" class="segmented" options={choices} value={reach.value} onChoose={(chosen) => (reach.value = chosen)} />
      <Slider label="Minimum confidence" value={least.value} min={0} max={1} shown={percent(least.value)} tip="Points with a lower confidence stay unlabeled" onInput={(value) => (least.value = value)} />
      <p class="soft">Only unlabeled points are labelled. One undo reverts everything.</p>
      <div class="form-end">
        <Button label="Cancel" onClick={() => (applyOpen.value = false)} />
        <button type="submit" class="button primary" disabled={!canEdit.value}>Label the points</button>
      </div>
    </form>
  ); // prettier-ignore
}
