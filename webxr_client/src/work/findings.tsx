/** Suspicious places, and the way from one to the next. */
import type { Finding } from '../protocol/values';
import type { IconName } from '../common/icons';
import { plural } from '../common/format';
import { Button } from '../panels/parts/controls';
import { canReview } from '../store/state';
import { framesOf } from './model';
import { Entry } from './parts';
import {
  checking,
  checks,
  current,
  deny,
  draft,
  goToFinding,
  settle,
  step,
  waiting,
} from './review';
import { openWork } from './store';

const ICONS: Readonly<Partial<Record<Finding['kind'], IconName>>> = {
  name: 'swap',
  category: 'folder',
  few: 'points',
  stray: 'noise',
  jump: 'track',
  unlike: 'history',
  predicted: 'object',
  returned: 'eye',
};

export function Findings() {
  if (!checks.value) return <p class="soft empty">Checking the labels…</p>;
  const { length } = waiting.value;
  const at = waiting.value.findIndex(({ id }) => id === current.value);
  return (
    <>
      <div class="line spread" role="group" aria-label="Suspicious places">
        <Button
          icon="previous"
          tip="Previous suspicious place"
          disabled={length === 0}
          onClick={() => step(-1)}
        />
        <span class="number" aria-live="polite">
          {at < 0 ? plural(length, 'suspicious place') : `${at + 1} of ${length}`}
        </span>
        <Button
          icon="next"
          tip="Next suspicious place"
          disabled={length === 0}
          onClick={() => step(1)}
        />
      </div>
      {length === 0 && (
        <p class="soft empty">
          {checking.value ? 'Checking the labels…' : 'No suspicious places in these labels.'}
        </p>
      )}
      <ol class="entries">
        {waiting.value.map((finding) => (
          <Row key={finding.id} finding={finding} />
        ))}
      </ol>
      {checks.value.unchecked.map((sentence) => (
        <p key={sentence} class="soft">
          Not checked: {sentence}
        </p>
      ))}
    </>
  );
}

function Row({ finding }: { finding: Finding }) {
  const isCurrent = finding.id === current.value;
  return (
    <Entry
      icon={ICONS[finding.kind] ?? 'box'}
      current={isCurrent}
      about={framesOf(finding)}
      onClick={() => goToFinding(finding)}
      actions={isCurrent && <Actions finding={finding} />}
    >
      {finding.text}
    </Entry>
  );
}

function Actions({ finding }: { finding: Finding }) {
  const { kind, text, place, first, last } = finding;
  const asks = kind === 'returned';
  const note = (): void => {
    draft.value = { note: text, place, first, last };
    openWork('frames');
  };
  return (
    <div class="entry-actions line wrap">
      <Button
        icon="check"
        label={asks ? 'Yes' : 'Confirm'}
        tip="Confirm the labels as correct"
        kind="outlined"
        small
        disabled={!canReview.value}
        onClick={() => void settle(finding)}
      />
      {asks && (
        <Button
          icon="close"
          label="No"
          tip={`Clear the tracked label in ${framesOf(finding)}`}
          kind="outlined"
          small
          onClick={() => void deny(finding)}
        />
      )}
      {first !== null && <Button label="Write a note…" kind="outlined" small onClick={note} />}
    </div>
  );
}
