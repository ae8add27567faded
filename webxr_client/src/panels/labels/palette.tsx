/** The labels, at the side. */
import { computed } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { actions } from '../../store/actions';
import { finishLabel, isNew, newLabel } from '../../engine/labels/labels';
import type { Label } from '../../protocol/messages';
import { canEdit, state } from '../../store/state';
import { Button, NameField } from '../parts/controls';
import { count, plural } from '../../common/format';
import { LabelRow } from './label-row';
import {
  canGroup,
  listOpen,
  listed,
  search,
  shownGroups,
  wantsGroups,
} from '../../store/palette-list';
import { PaletteMenuButton } from './palette-menu';

export function Palette() {
  if (!state.sequence.value) return null;
  const palette = state.palette.value;
  return (
    <>
      <div class="panel-head line">
        <h2>Labels</h2>
        <span class="faint number">{palette.length > 0 ? palette.length : ''}</span>
        <span class="spacer" />
        <PaletteMenuButton />
        <Button
          icon="plus"
          tip="New label"
          keys="N"
          small
          disabled={!canEdit.value}
          onClick={() => void actions.labels.newLabel()}
        />
        <Button
          icon="close"
          tip="Close the labels"
          small
          class="sheet-part"
          onClick={() => (listOpen.value = false)}
        />
      </div>
      {palette.length > 0 && <PaletteSearch />}
      {palette.length === 0 && !newLabel.value ? <NoLabels /> : <LabelList />}
      <Unlabeled />
    </>
  );
}

function LabelList() {
  const groups = shownGroups.value;
  const numbers = new Map(listed.value.map((label, index) => [label.id, index + 1]));
  const active = state.activeLabel.value;
  // A label chosen by a search, a key or a click into the cloud may be outside the visible list.
  useEffect(() => {
    document
      .querySelector(`#palette [data-label="${active}"]`)
      ?.scrollIntoView({ block: 'nearest' });
  }, [active, groups]);
  return (
    <div class="labels" role="grid" aria-label="Labels">
      {groups.map(({ category, labels }) => (
        <div
          key={category ?? ''}
          role="rowgroup"
          aria-label={category === null ? 'All labels' : category || 'No category'}
        >
          {category !== null && <GroupHead category={category} labels={labels} />}
          {labels.map((label) =>
            isNew(newLabel.value, label) ? null : (
              <LabelRow key={label.id} label={label} number={numbers.get(label.id) ?? 0} />
            ),
          )}
        </div>
      ))}
      <NewRow />
      {groups.length === 0 && !newLabel.value && <NothingFound />}
    </div>
  );
}

function GroupHead({ category, labels }: { category: string; labels: readonly Label[] }) {
  const points = labels.reduce((sum, { id }) => sum + (state.counts.value.get(id) ?? 0), 0);
  return (
    <div class="group-head line spread faint" role="row">
      <span role="gridcell" class="name">
        {category || 'No category'}
      </span>
      <span role="gridcell" class="number" data-tip={`${plural(points, 'point')} in all frames`}>
        {labels.length}
      </span>
    </div>
  );
}

function NothingFound() {
  return (
    <div role="row" class="no-labels">
      <span role="gridcell">No label contains “{search.value}”.</span>
    </div>
  );
}

/** The row of a new label while its name is typed. */
function NewRow() {
  const draft = newLabel.value;
  if (!draft) return null;
  return (
    <div class="label-row" role="row" aria-selected aria-label={draft.name}>
      <span role="gridcell" class="color-button" style={{ '--color': draft.color }} />
      <span role="gridcell">
        <NameField name={draft.name} onFinish={(name) => void finishLabel(name)} />
      </span>
    </div>
  );
}

function NoLabels() {
  return (
    <div class="labels">
      <div class="empty stack">
        <p>A label is one object, such as “car 1”, or one class, such as “ground”.</p>
        <Button
          icon="plus"
          label="Create a label"
          kind="primary"
          disabled={!canEdit.value}
          onClick={() => void actions.labels.newLabel()}
        />
      </div>
    </div>
  );
}

const labelledInFrame = computed(() => {
  let labelled = 0;
  for (const row of state.timeline.value.rows.values()) {
    labelled += row.points[state.frame.value] ?? 0;
  }
  return labelled;
});

function Unlabeled() {
  const { hideUnlabeled } = state.view.value;
  const total = state.sequence.value?.points[state.frame.value] ?? 0;
  const left = Math.max(0, total - labelledInFrame.value);
  return (
    <div class="unlabeled">
      <span class="swatch" />
      <span class="name">Unlabelled</span>
      <span class="number faint" data-tip={`${plural(left, 'point')} of this frame`}>
        {count(left)}
      </span>
      <Button
        icon={hideUnlabeled ? 'hidden' : 'eye'}
        tip={hideUnlabeled ? 'Show unlabelled points' : 'Hide unlabelled points'}
        small
        pressed={hideUnlabeled}
        onClick={() => actions.view.setView({ hideUnlabeled: !hideUnlabeled })}
      />
    </div>
  );
}

/** Above the labels: a search, headings by category, and the meaning of a row's numbers. */
const FIELD = 'label-search';

/** Put the cursor into the search. */
export function openSearch(): void {
  listOpen.value = true;
  const field = document.getElementById(FIELD) as HTMLInputElement | null;
  field?.focus();
  field?.select();
}

function PaletteSearch() {
  return (
    <>
      <div class="label-search line">
        <input
          id={FIELD}
          class="field grow"
          type="search"
          aria-label="Search labels"
          placeholder={`Search ${plural(listed.value.length, 'label')}`}
          data-tip="Search by name or category"
          data-keys="/"
          spellcheck={false}
          value={search.value}
          onInput={(event) => (search.value = event.currentTarget.value)}
          onKeyDown={onKey}
        />
        {canGroup.value && (
          <Button
            icon="folder"
            tip="Group by category"
            small
            pressed={wantsGroups.value}
            onClick={() => (wantsGroups.value = !wantsGroups.value)}
          />
        )}
      </div>
      <div class="count-head line spread faint" aria-hidden="true">
        <span>Name, category</span>
        <span>
          Points here
          <br />
          in all frames
        </span>
      </div>
    </>
  );
}

/** Enter takes the first label that is found; Escape ends the search. */
function onKey(event: KeyboardEvent): void {
  if (event.key !== 'Enter' && event.key !== 'Escape') return;
  event.preventDefault();
  event.stopPropagation();
  const first = shownGroups.peek()[0]?.labels[0];
  if (event.key === 'Enter' && first) actions.labels.selectLabel(first.id);
  search.value = '';
  (event.currentTarget as HTMLElement).blur();
}
