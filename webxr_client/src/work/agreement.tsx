/** Agreement of two people: figures, the places where they differ, the choice of one, scores. */
import type { Agreement, Disagreement } from '../protocol/values';
import { plural, shortCount } from '../common/format';
import type { IconName } from '../common/icons';
import { may } from '../engine/recordings/projects';
import { Button } from '../panels/parts/controls';
import { RadioGroup } from '../panels/parts/radio-group';
import { state } from '../store/state';
import * as copies from './copies';
import type { Group, Pair } from './copies';
import { percent, worstFrames } from './model';
import { Choice, Table } from '../panels/parts/fields';
import { Entry } from './parts';
import { visit } from './places';
import { project } from './store';

interface PairProps {
  of: Pair;
  names: readonly [string, string];
}

export function AgreementTab() {
  const [all, of] = [copies.pairs.value, copies.pair.value];
  const people = (all ?? []).filter(({ places }) => places !== null);
  const others = copies.others.value;
  const waits = all === null || (copies.chosenPair.value !== '' && !of);
  return (
    <>
      {people.length + others.length > 1 && <PairChoice people={people} />}
      {waits && <p class="soft empty">Comparing…</p>}
      {all && people.length + others.length === 0 && (
        <p class="soft empty">
          This recording has no copies to compare. Under Tasks, make tasks with at least two
          annotators per task.
        </p>
      )}
      {of && <Compared of={of} names={[copies.personOf(of.first), copies.personOf(of.second)]} />}
      <Scores />
    </>
  );
}

/** Choice of two annotators, or of another import of the same points. */
function PairChoice({ people }: { people: readonly Pair[] }) {
  const first = copies.original.value!;
  const imports = copies.others.value.map(({ id }) => ({ first, second: id }));
  const pairs = [...people, ...imports].map((each) => {
    const words = `${copies.personOf(each.first)} and ${copies.personOf(each.second)}`;
    return [copies.keyOf(each), words] as const;
  });
  return (
    <Choice
      label="Compared people"
      value={copies.pair.value ? copies.keyOf(copies.pair.value) : copies.chosenPair.value}
      choices={people.length === 0 ? [['', 'Compare with another recording…'], ...pairs] : pairs}
      onChange={(key) => void copies.choose(key)}
    />
  );
}

function Compared({ of, names }: PairProps) {
  const { agreement, places } = of;
  return (
    <section class="stack" aria-label="Agreement">
      <h3>{names.join(' and ')}</h3>
      {agreement.frames.length === 0 ? (
        <p class="soft">Both people have not handed in the same frame yet.</p>
      ) : (
        <>
          <Figures agreement={agreement} open={places === null} />
          <Look names={names} />
          {places === null ? <Worst agreement={agreement} /> : <Places of={of} names={names} />}
        </>
      )}
    </section>
  );
}

/** Agreement by points, in all and by label. */
function Figures({ agreement, open }: { agreement: Agreement; open: boolean }) {
  const { same, miou, labels } = agreement;
  return (
    <details open={open}>
      <summary>
        <strong>{percent(same)}</strong> of points agree, mean IoU <strong>{percent(miou)}</strong>
      </summary>
      <Table
        head={[['Label'], ['IoU']]}
        rows={labels.map(({ name, iou }) => [
          name,
          <>
            <meter min={0} max={1} low={0.5} high={0.8} optimum={1} value={iou} /> {percent(iou)}
          </>,
        ])}
      />
    </details>
  );
}

/** Choice of the labels that the cloud shows. */
function Look({ names: [one, other] }: Pick<PairProps, 'names'>) {
  const shown = copies.shows.value;
  const legend = { first: `only ${one}`, second: `only ${other}`, other: 'other classes', same: 'the same' }; // prettier-ignore
  return (
    <>
      <RadioGroup
        label="Show the labels of"
        options={[
          { value: 'recording', label: 'Recording', tip: 'The labels of the recording' },
          { value: 'first', label: one, tip: `The labels of ${one}` },
          { value: 'second', label: other, tip: `The labels of ${other}` },
          { value: 'difference', label: 'Both', tip: 'The differences of both' },
        ]}
        value={shown}
        onChoose={(what) => (copies.shows.value = what)}
      />
      {shown === 'difference' && (
        <p class="line wrap small">
          {Object.entries(legend).map(([kind, words]) => (
            <span key={kind} class="difference" style={{ '--difference': `var(--${kind})` }}>
              {words}
            </span>
          ))}
        </p>
      )}
      {state.sequence.value?.large && shown !== 'recording' && (
        <p class="soft">For a recording of this size, only its own labels are shown.</p>
      )}
    </>
  );
}

function Worst({ agreement }: { agreement: Agreement }) {
  const worst = worstFrames(agreement);
  if (worst.length === 0) return null;
  return (
    <div class="line wrap small" role="group" aria-label="Frames with the largest differences">
      <span class="soft">Largest differences in frame</span>
      {worst.map(({ frame, differ, labelled }) => (
        <Button
          key={frame}
          label={String(frame)}
          kind="outlined"
          small
          tip={`${percent(differ / labelled)} of the labelled points`}
          onClick={() => visit(frame, null)}
        />
      ))}
    </div>
  );
}

const ICONS: Readonly<Record<Disagreement['kind'], IconName>> = {
  missed: 'minus',
  added: 'plus',
  split: 'split',
  merged: 'merge',
  renamed: 'swap',
  outline: 'lasso',
};

function Places({ of, names }: PairProps) {
  const groups = copies.groups.value;
  if (groups.length === 0) return <p class="soft">Both people agree on all objects.</p>;
  return (
    <>
      <span class="soft">{plural(groups.length, 'difference')}</span>
      <ul class="entries" aria-label="Differences">
        {groups.map((group) => (
          <Difference key={group.key} group={group} names={names} of={of} />
        ))}
      </ul>
      <Whole names={names} of={of} />
    </>
  );
}

function Difference({ group, names, of }: PairProps & { group: Group }) {
  const { places, has, points } = group;
  const [first] = places;
  const isCurrent = copies.current.value?.key === group.key;
  const frames = places.length === 1 ? `frame ${first!.frame}` : plural(places.length, 'frame');
  const matches = has === null ? '' : ` · the recording matches ${names[has]}`;
  return (
    <Entry
      icon={ICONS[first!.kind]}
      current={isCurrent}
      about={`${frames} · ${shortCount(points)} points${matches}`}
      onClick={() => copies.visitGroup(group)}
      actions={isCurrent && <Take group={group} names={names} of={of} />}
    >
      {copies.wordsOf(first!, names)}
    </Entry>
  );
}

/** Choice of the person to take from; the one that the recording agrees with is pressed. */
function Take({ group, names, of }: PairProps & { group: Group }) {
  const { places, has } = group;
  const frame = copies.current.value!.frame;
  const at = places.findIndex((place) => place.frame === frame);
  const step = (by: number): void =>
    copies.visitGroup(group, places[(at + by + places.length) % places.length]);
  const where = places.length === 1 ? ' here' : ', in all frames of the difference';
  return (
    <div class="entry-actions line wrap">
      {[of.first, of.second].map((copy, who) => (
        <Button
          key={copy}
          label={`Use ${names[who]}’s`}
          kind="outlined"
          small
          pressed={has === who}
          tip={`Copy these labels into the recording${where}`}
          onClick={() => void copies.take(copy, group)}
        />
      ))}
      {places.length > 1 && (
        <span class="group">
          <Button icon="previous" tip="Previous frame with it" small onClick={() => step(-1)} />
          <span class="number soft">frame {frame}</span>
          <Button icon="next" tip="Next frame with it" small onClick={() => step(1)} />
        </span>
      )}
    </div>
  );
}

const MAJORITY = 'majority';

function Whole({ names, of }: PairProps) {
  const people = new Set(
    (copies.pairs.value ?? []).flatMap(({ first, second }) => [first, second]),
  );
  const choices = [[of.first, names[0]], [of.second, names[1]], [MAJORITY, 'the majority']] as const; // prettier-ignore
  return (
    <div class="line wrap" role="group" aria-label="Use all labels of">
      <span class="soft">Use all labels of</span>
      {choices.slice(0, people.size > 2 ? 3 : 2).map(([copy, name]) => (
        <Button
          key={copy}
          label={name}
          kind="outlined"
          small
          onClick={() => void copies.take(copy)}
        />
      ))}
    </div>
  );
}

const SCORES = [
  ['Person'],
  ['IoU', 'Mean IoU by class, of points'],
  ['Found', 'Ground truth objects that the person labelled'],
  ['Missed', 'Ground truth objects that the person missed'],
  ['Added', 'Labelled objects that are not in the ground truth'],
  ['Frames'],
] as const;

function Scores() {
  const rows = copies.scores.value.map(({ person, miou, found, missed, added, frames }) => [
    person,
    percent(miou),
    ...[found, missed, added, frames].map(String),
  ]);
  return (
    <section class="stack" aria-label="Scores">
      <h3>Scores against ground truth</h3>
      {rows.length > 0 ? (
        <Table head={SCORES} rows={rows} />
      ) : (
        <p class="soft">No frames with ground truth have been labelled yet.</p>
      )}
      {may(project.value, 'manager') && (
        <Button
          label="Use this recording as ground truth"
          kind="outlined"
          small
          tip="The next annotator gets a copy without labels and is scored against the labels of this recording"
          onClick={() => void copies.giveAsTruth()}
        />
      )}
    </section>
  );
}
