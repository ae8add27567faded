/** Suspicious things, and the way from one to the next. */
import { Button } from '../panels/parts/controls';
import { plural } from '../common/format';
import { Icon, type IconName } from '../common/icons';
import { canReview } from '../store/state';
import { type Finding, framesOf } from './model';
import { checking, checks, current, draft, goTo, reviewTab, settle, step, waiting } from './store';

const ICONS: Readonly<Record<Finding['kind'], IconName>> = {
  name: 'swap',
  category: 'folder',
  few: 'points',
  stray: 'noise',
  jump: 'track',
  unlike: 'history',
  predicted: 'object',
  box_jump: 'box',
  box_size: 'box',
  box_overlap: 'box',
  box_ground: 'box',
  box_empty: 'box',
  box_outside: 'box',
};

export function Findings() {
  if (!checks.value) return <p class="soft empty">Checking the labels…</p>;
  const { length } = waiting.value;
  const at = waiting.value.findIndex(({ id }) => id === current.value);
  return (
    <>
      <div class="review-steps" role="group" aria-label="Suspicious places">
        <Button
          icon="previous"
          tip="Previous suspicious place"
          disabled={length === 0}
          onClick={back}
        />
        <span class="number" aria-live="polite">
          {at < 0 ? plural(length, 'suspicious place') : `${at + 1} of ${length}`}
        </span>
        <Button icon="next" tip="Next suspicious place" disabled={length === 0} onClick={forth} />
      </div>
      {length === 0 && (
        <p class="soft empty">
          {checking.value ? 'Checking the labels…' : 'No suspicious places in these labels.'}
        </p>
      )}
      <ol class="findings">
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

const back = (): void => step(-1);
const forth = (): void => step(1);

function Row({ finding }: { finding: Finding }) {
  const here = finding.id === current.value;
  return (
    <li data-current={here || undefined}>
      <button
        type="button"
        class="menu-item"
        aria-current={here ? 'true' : undefined}
        onClick={() => goTo(finding)}
      >
        <Icon name={ICONS[finding.kind]} />
        <span class="what">
          {finding.text}
          <span class="soft">{framesOf(finding)}</span>
        </span>
      </button>
      {here && (
        <div class="finding-actions">
          <Button
            icon="check"
            label="Confirm"
            tip="Confirm the labels as correct"
            kind="outlined"
            small
            disabled={!canReview.value}
            onClick={() => void settle(finding)}
          />
          {finding.first !== null && (
            <Button label="Write a note…" kind="outlined" small onClick={() => noteOf(finding)} />
          )}
        </div>
      )}
    </li>
  );
}

function noteOf({ text, place, first, last }: Finding): void {
  draft.value = { note: text, place, first, last };
  reviewTab.value = 'frames';
}
