/** Panel at the side: the classes of the classifier, their accuracy, and confused pairs. */
import { signal } from '@preact/signals';
import { percent, plural } from '../common/format';
import { Button, Swatch } from '../panels/parts/controls';
import { PopoverButton } from '../panels/parts/popover';
import { RadioGroup, type RadioOption } from '../panels/parts/radio-group';
import { canEdit, canManage, state } from '../store/state';
import { coloursOf, type Prediction, type Scope, type Tally, talliesOf } from './model';
import { chooseClassifier, classifier, classifiers, closeExample, deleteClassifier, exampleOpen, makeClassifier, natural, nextDoubt, only, predicted, scope, teachOpenRecording } from './store'; // prettier-ignore

export function ExamplePanel() {
  const shown = exampleOpen.value && state.xr.value.session !== 'running';
  if (!shown || !state.sequence.value || !classifier.value) return null;
  const prediction = predicted.value;
  return (
    <>
      <header class="panel-head line spread">
        <h2 class="name">By example: {classifier.value.name}</h2>
        <span class="line">
          <Choice />
          <Button icon="close" tip="Close: hides the prediction, keeps the labels" small onClick={closeExample} />
        </span>
      </header>
      <div class="work-body stack">
        <Classes prediction={prediction} />
        <Legend />
        {prediction && <Confusions prediction={prediction} />}
        <Scopes />
      </div>
    </>
  ); // prettier-ignore
}

const choiceOpen = signal(false);

/** Other classifiers, and the examples of this one. */
function Choice() {
  const chosen = classifier.value!;
  const sequence = state.sequence.value!.id;
  return (
    <PopoverButton open={choiceOpen} icon="more" small tip="Choose, make or delete a classifier" label="Classifier" class="form">
      <select class="field" aria-label="Classifier" value={chosen.id} onChange={(event) => chooseClassifier(event.currentTarget.value)}>
        {classifiers.value?.map(({ id, name }) => <option key={id} value={id}>{name}</option>)}
      </select>
      {canEdit.value && (
        <div class="form-end">
          {canManage.value && <Button label="Delete" kind="danger" onClick={() => void deleteClassifier()} />}
          <Button label="New classifier" kind="outlined" onClick={() => void makeClassifier()} />
          {!(sequence in chosen.taught_by) && <Button label="Teach with this recording" kind="primary" onClick={() => void teachOpenRecording()} />}
        </div>
      )}
    </PopoverButton>
  ); // prettier-ignore
}

function Classes({ prediction }: { prediction: Prediction | null }) {
  const { classes } = classifier.value!;
  const tallies = prediction && talliesOf(prediction, classes.length);
  return (
    <ul class="example-classes" aria-label="Classes">
      {classes.map((name, k) => (
        <li key={name}>
          <Class name={name} place={k} all={tallies?.[0]} own={tallies?.[k + 1]} doubts={prediction?.doubts[k]} />
        </li>
      ))}
    </ul>
  ); // prettier-ignore
}

interface ClassProps {
  name: string;
  place: number;
  all: Tally | undefined;
  own: Tally | undefined;
  doubts: number | undefined;
}

/** A class: a click shows it alone. */
function Class({ name, place, all, own, doubts }: ClassProps) {
  const { classes, examples, held_out: held } = classifier.value!;
  const alone = only.value === name;
  const tested = held[name];
  return (
    <button type="button" class="button example-class" aria-pressed={alone} data-tip={alone ? 'Show all classes' : `Show ${name} alone`} onClick={() => (only.value = alone ? null : name)}>
      <Swatch color={coloursOf(classes, state.palette.value)[place]!} />
      <span class="name">{name}</span>
      <b class="number">{all && own ? percent(own.points / Math.max(1, all.points)) : '–'}</b>
      {place < 9 && <span class="kbd">{place + 1}</span>}
      <span class="facts soft small">
        {tested && tested.accuracy !== null ? `expected accuracy ${percent(tested.accuracy)}` : 'accuracy not measured yet'}
        {' · '}{tested?.places ? plural(tested.places, 'painted place') : plural(examples[name] ?? 0, 'example')}
        {doubts !== undefined && ` · ${plural(doubts, 'doubt')}`}
      </span>
    </button>
  ); // prettier-ignore
}

function Legend() {
  return (
    <p class="soft small">
      Light: labelled. Strong colour: predicted, the greyer, the less certain. Hold{' '}
      <span class="kbd">`</span> for{' '}
      <button type="button" class="button small" aria-pressed={natural.value} onClick={() => (natural.value = !natural.value)}>
        natural colours
      </button>
    </p>
  ); // prettier-ignore
}

/** Pairs of classes that are listed at most, and the least share that is. */
const [MOST_PAIRS, LEAST_SHARE] = [5, 0.001];

/** Pairs of classes with points in doubt between them; a click leads to one of these. */
function Confusions({ prediction }: { prediction: Prediction }) {
  const { classes } = classifier.value!;
  const pairs = prediction.confused
    .map(([one, other, points]) => ({ names: [classes[one]!, classes[other]!], share: points / prediction.kind.length }))
    .filter(({ share }) => share >= LEAST_SHARE)
    .sort((one, other) => other.share - one.share)
    .slice(0, MOST_PAIRS); // prettier-ignore
  if (pairs.length === 0) return null;
  return (
    <section class="stack">
      <h3>In doubt between</h3>
      <ul aria-label="Confusions">
        {pairs.map(({ names, share }) => (
          <li key={names.join()}>
            <button type="button" class="menu-item" data-tip="Go to an example" onClick={() => void nextDoubt(names)}>
              <span class="name grow">{names.join(' ↔ ')}</span>
              <span class="number">{(share * 100).toFixed(share < 0.01 ? 1 : 0)} %</span>
            </button>
          </li>
        ))}
      </ul>
    </section>
  ); // prettier-ignore
}

const SCOPES: readonly RadioOption<Scope>[] = [
  { value: 'frame', label: 'This frame' },
  { value: 'recording', label: 'Recording' },
  { value: 'workspace', label: 'Workspace' },
];

function Scopes() {
  return (
    <section class="stack">
      <h3>Search for doubts in</h3>
      <RadioGroup label="Search for doubts in" options={SCOPES} value={scope.value} onChoose={(chosen) => (scope.value = chosen)} />
    </section>
  ); // prettier-ignore
}
