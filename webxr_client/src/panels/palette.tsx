/** The labels, at the side. */
import { computed } from '@preact/signals';
import { actions } from '../actions';
import { canEdit, state } from '../state';
import { Button } from './controls';
import { suggestColor, suggestName } from './colors';
import { count, plural } from './format';
import { Icon } from './icon';
import { LabelRow } from './label-row';
import { renaming } from './renaming';

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
          onClick={() => void addLabel()}
        />
      </div>
      <ul class="labels" role="listbox" aria-label="Labels">
        {palette.map((label, index) => (
          <LabelRow key={label.id} label={label} number={index + 1} />
        ))}
        {palette.length === 0 && <NoLabels />}
      </ul>
      <Unlabeled />
    </>
  );
}

/** A new label in the active one's category, with its name ready to be typed over. */
export async function addLabel(): Promise<void> {
  const palette = state.palette.peek();
  const active = palette.find((label) => label.id === state.activeLabel.peek());
  const category = active?.category ?? '';
  const name = suggestName(
    category,
    palette.map((label) => label.name),
  );
  const color = suggestColor(palette.map((label) => label.color));
  const id = await actions.createLabel(name, color, category);
  if (typeof id === 'number') renaming.value = id;
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
        onClick={() => void addLabel()}
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
