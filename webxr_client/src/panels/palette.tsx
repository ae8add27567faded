/** The labels, at the side. */
import { computed } from '@preact/signals';
import { actions } from '../actions';
import { finishLabel, isNew, newLabel } from '../engine/new-label';
import { canEdit, state } from '../state';
import { Button } from './controls';
import { count, plural } from './format';
import { Icon } from './icon';
import { LabelRow } from './label-row';
import { NameField } from './name-field';

export function Palette() {
  if (!state.sequence.value) return null;
  const palette = state.palette.value;
  return (
    <>
      <div class="panel-head">
        <h2>Labels</h2>
        <span class="faint number">{palette.length > 0 ? palette.length : ''}</span>
        <span class="spacer" />
        <Button
          icon="plus"
          tip="New label"
          keys="N"
          small
          disabled={!canEdit.value}
          onClick={() => void actions.newLabel()}
        />
      </div>
      <ul class="labels" role="listbox" aria-label="Labels">
        {palette.map((label, index) =>
          isNew(newLabel.value, label) ? null : (
            <LabelRow key={label.id} label={label} number={index + 1} />
          ),
        )}
        <NewRow />
        {palette.length === 0 && !newLabel.value && <NoLabels />}
      </ul>
      <Unlabeled />
    </>
  );
}

/** The row of a label whose name is typed for the first time. */
function NewRow() {
  const draft = newLabel.value;
  if (!draft) return null;
  return (
    <li class="label-row" role="option" aria-selected aria-label={draft.name}>
      <span class="color-button" style={{ '--color': draft.color }} />
      <NameField name={draft.name} onFinish={(name) => void finishLabel(name)} />
    </li>
  );
}

function NoLabels() {
  return (
    <li class="no-labels">
      <p>A label is one thing to follow: a pin, a hand, a person.</p>
      <Button
        icon="plus"
        label="First label"
        kind="primary"
        disabled={!canEdit.value}
        onClick={() => void actions.newLabel()}
      />
    </li>
  );
}

const labelledHere = computed(() => {
  let labelled = 0;
  for (const row of state.timeline.value.rows.values()) {
    labelled += row.points[state.frame.value] ?? 0;
  }
  return labelled;
});

function Unlabeled() {
  const { hideUnlabeled } = state.view.value;
  const total = state.sequence.value?.points[state.frame.value] ?? 0;
  const left = Math.max(0, total - labelledHere.value);
  return (
    <div class="unlabeled">
      <span class="swatch" />
      <span class="name">Unlabeled</span>
      <span class="number faint" data-tip={`${plural(left, 'point')} of this frame`}>
        {count(left)}
      </span>
      <button
        type="button"
        class="button icon-only small"
        aria-label={hideUnlabeled ? 'Show unlabeled points' : 'Hide unlabeled points'}
        data-tip={hideUnlabeled ? 'Show unlabeled points' : 'Hide unlabeled points'}
        aria-pressed={hideUnlabeled}
        onClick={() => actions.setView({ hideUnlabeled: !hideUnlabeled })}
      >
        <Icon name={hideUnlabeled ? 'hidden' : 'eye'} />
      </button>
    </div>
  );
}
