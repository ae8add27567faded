/** Rare actions on a label. */
import type { RefObject } from 'preact';
import { useState } from 'preact/hooks';
import { categoriesSelected, categoryChoices } from '../../engine/labels/categories';
import { actions } from '../../store/actions';
import type { Label } from '../../protocol/messages';
import { canEdit, state } from '../../store/state';
import { Button } from '../parts/controls';
import { Icon } from '../../common/icons';
import { lossOf, pointsOf } from './label-points';
import { shiftLabel } from './label-rows';
import { renaming } from '../../store/palette-list';
import { Choice, Row } from '../parts/fields';
import { MenuItem, Popover } from '../parts/popover';

interface LabelMenuProps {
  label: Label;
  anchor: RefObject<HTMLElement | null>;
  onClose: () => void;
}

export function LabelMenu({ label, anchor, onClose }: LabelMenuProps) {
  const [confirm, setConfirm] = useState(false);
  const [inFrame, all] = lossOf(label.id);
  const remove = (): void => {
    onClose();
    void actions.labels.deleteLabel(label.id);
  };
  return (
    <Popover anchor={anchor} label={label.name} onClose={onClose}>
      {confirm ? (
        <div class="empty stack">
          <p>
            {inFrame} and {all} will lose the label “{label.name}”. This can be undone.
          </p>
          <div class="form-end">
            <Button label="Keep" onClick={onClose} />
            <Button label="Delete" kind="outlined" onClick={remove} />
          </div>
        </div>
      ) : (
        <>
          <CategoryField label={label} />
          <MenuItem
            icon="pencil"
            label="Rename"
            disabled={!canEdit.value}
            onClick={() => (renaming.value = label.id)}
          />
          <LabelParts label={label} onClose={onClose} />
          {([-1, 1] as const).map((by) => (
            <MenuItem
              key={by}
              icon="chevron"
              label={by < 0 ? 'Move up' : 'Move down'}
              disabled={!canEdit.value}
              stays
              onClick={() => shiftLabel(label.id, by)}
            >
              <span class="end">Alt {by < 0 ? '↑' : '↓'}</span>
            </MenuItem>
          ))}
          <MenuItem
            icon={label.locked ? 'unlock' : 'lock'}
            label={label.locked ? 'Unlock' : 'Lock'}
            disabled={!canEdit.value}
            stays
            onClick={() => void actions.labels.toggleLock(label.id)}
          />
          <MenuItem
            icon={label.visible ? 'hidden' : 'eye'}
            label={label.visible ? 'Hide' : 'Show'}
            disabled={!canEdit.value}
            stays
            onClick={() => void actions.labels.toggleVisible(label.id)}
          />
          <MenuItem
            icon="solo"
            label={state.solo.value === label.id ? 'Show all' : 'Show only this'}
            stays
            onClick={() => actions.labels.solo(state.solo.peek() === label.id ? null : label.id)}
          />
          <MenuItem
            icon="trash"
            label="Delete"
            disabled={!canEdit.value || label.locked}
            stays
            onClick={() => (pointsOf(label.id).all > 0 ? setConfirm(true) : remove())}
          >
            {label.locked && <span class="end">locked</span>}
          </MenuItem>
        </>
      )}
    </Popover>
  );
}

function CategoryField({ label }: { label: Label }) {
  return (
    <Row label="Category">
      {categoriesSelected.value ? (
        <SelectedCategory label={label} />
      ) : (
        <AnyCategory label={label} />
      )}
    </Row>
  );
}

/** Choice among the categories that the project has selected and the label's own. */
function SelectedCategory({ label }: { label: Label }) {
  const choices = [...new Set(['', label.category, ...categoryChoices.value])];
  return (
    <Choice
      value={label.category}
      choices={choices.map((category) => [category, category || 'none'] as const)}
      disabled={!canEdit.value}
      onChange={(category) => void actions.labels.updateLabel(label.id, { category })}
    />
  );
}

function AnyCategory({ label }: { label: Label }) {
  return (
    <>
      <input
        class="field"
        list="categories"
        data-autofocus
        defaultValue={label.category}
        maxLength={80}
        disabled={!canEdit.value}
        onKeyDown={(event) => event.key !== 'Escape' && event.stopPropagation()}
        onChange={(event) => {
          void actions.labels.updateLabel(label.id, { category: event.currentTarget.value.trim() });
        }}
      />
      <datalist id="categories">
        {categoryChoices.value.map((category) => (
          <option key={category} value={category} />
        ))}
      </datalist>
    </>
  );
}

/** In a label's menu: make it part of another one, or split it. */
interface LabelPartsProps {
  label: Label;
  onClose: () => void;
}

function LabelParts({ label, onClose }: LabelPartsProps) {
  const pointsInFrame = state.timeline.value.rows.get(label.id)?.points[state.frame.value] ?? 0;
  const others = state.palette.value.filter(({ id, locked }) => id !== label.id && !locked);
  const may = canEdit.value && !label.locked;
  return (
    <>
      <MenuItem
        icon="split"
        label="Split into parts"
        tip="Each separate part in this frame gets its own label"
        disabled={!may || pointsInFrame === 0}
        onClick={() => void actions.labels.splitLabel(label.id)}
      />
      <label class="menu-item">
        <Icon name="merge" />
        <Choice
          label="Merge into"
          value=""
          choices={[['', 'Merge into…'], ...others.map(({ id, name }) => [`${id}`, name] as const)]}
          disabled={!may || others.length === 0}
          onChange={(id) => {
            onClose();
            void actions.labels.mergeLabel(label.id, Number(id));
          }}
        />
      </label>
    </>
  );
}
