/** Agreement of people on copies of the recording: figures, places, whose is taken, scores. */
import { plural, shortCount } from '../common/format';
import { Icon, type IconName } from '../common/icons';
import { Button } from '../panels/parts/controls';
import { RadioGroup, type RadioOption } from '../panels/parts/radio-group';
import { Figures, Legend } from '../reviewing/agreement';
import { percent } from '../reviewing/model';
import { state } from '../store/state';
import {
  at,
  current,
  type Disagreement,
  giveAsTruth,
  type Group,
  groups,
  type Pair,
  pair,
  pairs,
  personOf,
  scores,
  type Shows,
  shows,
  take,
  visitGroup,
  type Who,
  wordsOf,
} from './copies';
import { project } from './store';
import { may } from './tasks';

type Names = readonly [string, string];

export function AgreementTab() {
  const found = pairs.value;
  return (
    <>
      {found === null && <p class="soft empty">Comparing…</p>}
      {found?.length === 0 && (
        <p class="soft empty">
          This recording has no copies to compare. Under Tasks, make tasks with at least two
          annotators per task.
        </p>
      )}
      {pair.value && <Compared of={pair.value} all={found!} />}
      <Scores />
    </>
  );
}

function Compared({ of, all }: { of: Pair; all: readonly Pair[] }) {
  const names: Names = [personOf(of.first), personOf(of.second)];
  return (
    <section class="own-tasks" aria-label="Agreement">
      <h3>
        {names[0]} and {names[1]}
      </h3>
      {all.length > 1 && <Pairs all={all} />}
      {of.agreement.frames.length === 0 ? (
        <p class="soft">Both people have not handed in the same frame yet.</p>
      ) : (
        <>
          <details>
            <summary>
              <strong>{percent(of.agreement.same)}</strong> of points agree, mean IoU{' '}
              <strong>{percent(of.agreement.miou)}</strong>
            </summary>
            <Figures agreement={of.agreement} />
          </details>
          <Look names={names} />
          <Places names={names} of={of} />
          <Whole names={names} of={of} people={new Set(all.flatMap((each) => [each.first, each.second])).size} />
        </>
      )}
    </section>
  ); // prettier-ignore
}

function Pairs({ all }: { all: readonly Pair[] }) {
  return (
    <select
      aria-label="Compared people"
      value={at.value}
      onChange={({ currentTarget }) => {
        at.value = Number(currentTarget.value);
        current.value = null;
      }}
    >
      {all.map(({ first, second }, k) => (
        <option key={first + second} value={k}>
          {personOf(first)} and {personOf(second)}
        </option>
      ))}
    </select>
  );
}

/** Choice of the labels that the cloud shows. */
function Look({ names: [one, other] }: { names: Names }) {
  const options: readonly RadioOption<Shows>[] = [
    { value: 'recording', label: 'Recording', tip: 'The labels of the recording' },
    { value: 'first', label: one, tip: `The labels of ${one}` },
    { value: 'second', label: other, tip: `The labels of ${other}` },
    { value: 'difference', label: 'Both', tip: 'The differences of both' },
  ];
  const legend = [
    ['first', `only ${one}`],
    ['second', `only ${other}`],
    ['other', 'other classes'],
    ['same', 'the same'],
  ] as const;
  return (
    <div class="compared-look">
      <RadioGroup
        label="Show the labels of"
        class="segmented compared-shows"
        options={options}
        value={shows.value}
        onChoose={(what) => (shows.value = what)}
      />
      {shows.value === 'difference' && (
        <p class="worst">
          <Legend words={legend} />
        </p>
      )}
      {state.sequence.value?.large && shows.value !== 'recording' && (
        <p class="soft">For a recording of this size, only its own labels are shown.</p>
      )}
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

function Places({ names, of }: { names: Names; of: Pair }) {
  const found = groups.value;
  if (found.length === 0) return <p class="soft">Both people agree on all objects.</p>;
  return (
    <>
      <span class="soft">{plural(found.length, 'difference')}</span>
      <ul class="findings" aria-label="Differences">
        {found.map((group) => (
          <Entry key={group.key} group={group} names={names} of={of} />
        ))}
      </ul>
    </>
  );
}

function Entry({ group, names, of }: { group: Group; names: Names; of: Pair }) {
  const here = current.value?.key === group.key;
  const [place] = group.places;
  const frames = group.places.length === 1 ? `frame ${place!.frame}` : plural(group.places.length, 'frame'); // prettier-ignore
  return (
    <li data-current={here || undefined}>
      <button
        type="button"
        class="menu-item"
        aria-current={here ? 'true' : undefined}
        onClick={() => visitGroup(group)}
      >
        <Icon name={ICONS[place!.kind]} />
        <span class="what">
          {wordsOf(place!, names)}
          <span class="soft">
            {frames} · {shortCount(group.points)} points
            {group.has !== null && ` · the recording matches ${names[group.has]}`}
          </span>
        </span>
      </button>
      {here && <Choice group={group} names={names} of={of} />}
    </li>
  );
}

/** Choice of the person to take from; the one that the recording agrees with is pressed. */
function Choice({ group, names, of }: { group: Group; names: Names; of: Pair }) {
  const { places } = group;
  const frame = current.value!.frame;
  const at = places.findIndex((place) => place.frame === frame);
  const step = (by: number): void => visitGroup(group, places[(at + by + places.length) % places.length]); // prettier-ignore
  return (
    <div class="finding-actions">
      {([0, 1] as const).map((who) => (
        <TakeButton key={who} group={group} who={who} name={names[who]} copy={who ? of.second : of.first} />
      ))}
      {places.length > 1 && (
        <span class="group">
          <Button icon="previous" tip="Previous frame with this difference" small onClick={() => step(-1)} />
          <span class="number soft">frame {frame}</span>
          <Button icon="next" tip="Next frame with this difference" small onClick={() => step(1)} />
        </span>
      )}
    </div>
  ); // prettier-ignore
}

interface TakeProps {
  group: Group;
  who: Who;
  name: string;
  copy: string;
}

function TakeButton({ group, who, name, copy }: TakeProps) {
  const alone = group.places.length === 1;
  return (
    <Button
      label={`Use ${name}’s`}
      kind="outlined"
      small
      pressed={group.has === who}
      tip={
        alone
          ? 'Copy these labels into the recording here'
          : 'Copy these labels into the recording, in all frames of the difference'
      }
      onClick={() => void take(copy, group)}
    />
  );
}

function Whole({ names, of, people }: { names: Names; of: Pair; people: number }) {
  return (
    <div class="group" role="group" aria-label="Use all labels of">
      <span class="soft">Use all labels of</span>
      {[of.first, of.second].map((copy, who) => (
        <Button key={copy} label={names[who as Who]} kind="outlined" small onClick={() => void take(copy)} />
      ))}
      {people > 2 && (
        <Button label="the majority" kind="outlined" small tip="Points without a majority keep their labels" onClick={() => void take('majority')} />
      )}
    </div>
  ); // prettier-ignore
}

function Scores() {
  const of = project.value;
  return (
    <section class="own-tasks" aria-label="Scores">
      <h3>Scores against ground truth</h3>
      {scores.value.length === 0 && (
        <p class="soft">No frames with ground truth have been labelled yet.</p>
      )}
      {scores.value.length > 0 && (
        <table>
          <thead>
            <tr>
              <th>Person</th>
              <th data-tip="Mean IoU by class, of points">IoU</th>
              <th data-tip="Ground truth objects that the person labelled">Found</th>
              <th data-tip="Ground truth objects that the person missed">Missed</th>
              <th data-tip="Labelled objects that are not in the ground truth">Added</th>
              <th>Frames</th>
            </tr>
          </thead>
          <tbody>
            {scores.value.map(({ person, miou, found, missed, added, frames }) => (
              <tr key={person}>
                <td>{person}</td>
                <td class="number">{percent(miou)}</td>
                {[found, missed, added, frames].map((count, k) => (
                  <td key={k} class="number">
                    {count}
                  </td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      )}
      {of && may(of, 'manager') && (
        <Button
          label="Use this recording as ground truth"
          kind="outlined"
          small
          tip="The next annotator gets a copy without labels and is scored against the labels of this recording"
          onClick={() => void giveAsTruth()}
        />
      )}
    </section>
  );
}
