/** Rare actions on a label. */
import type { RefObject } from 'preact';
import { useState } from 'preact/hooks';
import { categoriesSelected, categoryChoices } from '../../engine/categories';
import { actions } from '../../store/actions';
import type { Label } from '../../protocol/messages';
import { canEdit, state } from '../../store/state';
import { Button } from '../parts/controls';
import { Icon } from '../../common/icons';
import { lossOf, pointsOf } from './label-points';
import { shiftLabel } from './label-rows';
import { renaming } from '../../store/palette-list';
import { Popover } from '../parts/popover';

interface LabelMenuProps {
  label: Label;
  anchor: RefObject<HTMLElement | null>;
  onClose: () => void;
}

export function LabelMenu({ label, anchor, onClose }: LabelMenuProps) {
  const [confirm, setConfirm] = useState(false);
  const [here, all] = lossOf(label.id);
  const remove = (): void => {
    onClose();
    void actions.deleteLabel(label.id);
  };
  return (
    <Popover anchor={anchor} label={label.name} onClose={onClose}>
      {confirm ? (
        <div class="empty stack">
          <p>
            {here} and {all} will lose the label “{label.name}”. This can be undone.
          </p>
          <div class="form-end">
            <Button label="Keep" onClick={onClose} />
            <Button label="Delete" kind="outlined" onClick={remove} />
          </div>
        </div>
      ) : (
        <>
          <CategoryField label={label} />
          <button
            type="button"
            class="menu-item"
            disabled={!canEdit.value}
            onClick={() => {
              onClose();
              renaming.value = label.id;
            }}
          >
            <Icon name="pencil" /> Rename
          </button>
          <LabelParts label={label} onClose={onClose} />
          {([-1, 1] as const).map((by) => (
            <button
              key={by}
              type="button"
              class="menu-item"
              disabled={!canEdit.value}
              onClick={() => shiftLabel(label.id, by)}
            >
              <Icon name="chevron" /> {by < 0 ? 'Move up' : 'Move down'}
              <span class="end">Alt {by < 0 ? '↑' : '↓'}</span>
            </button>
          ))}
          <button
            type="button"
            class="menu-item"
            disabled={!canEdit.value}
            onClick={() => void actions.toggleLock(label.id)}
          >
            <Icon name={label.locked ? 'unlock' : 'lock'} /> {label.locked ? 'Unlock' : 'Lock'}
          </button>
          <button
            type="button"
            class="menu-item"
            disabled={!canEdit.value}
            onClick={() => void actions.toggleVisible(label.id)}
          >
            <Icon name={label.visible ? 'hidden' : 'eye'} /> {label.visible ? 'Hide' : 'Show'}
          </button>
          <button
            type="button"
            class="menu-item"
            onClick={() => actions.solo(state.solo.peek() === label.id ? null : label.id)}
          >
            <Icon name="solo" /> {state.solo.value === label.id ? 'Show all' : 'Show only this'}
          </button>
          <button
            type="button"
            class="menu-item"
            disabled={!canEdit.value || label.locked}
            onClick={() => (pointsOf(label.id).all > 0 ? setConfirm(true) : remove())}
          >
            <Icon name="trash" /> Delete{label.locked && <span class="end">locked</span>}
          </button>
        </>
      )}
    </Popover>
  );
}

function CategoryField({ label }: { label: Label }) {
  return (
    <label class="row">
      <span>Category</span>
      {categoriesSelected.value ? (
        <SelectedCategory label={label} />
      ) : (
        <AnyCategory label={label} />
      )}
    </label>
  );
}

/** One of those that the project has selected; its own is there, too. */
function SelectedCategory({ label }: { label: Label }) {
  const choices = [...new Set(['', label.category, ...categoryChoices.value])];
  return (
    <select
      class="field"
      data-autofocus
      value={label.category}
      disabled={!canEdit.value}
      onChange={({ currentTarget: { value } }) => {
        void actions.updateLabel(label.id, { category: value });
      }}
    >
      {choices.map((category) => (
        <option key={category} value={category}>
          {category || 'none'}
        </option>
      ))}
    </select>
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
          void actions.updateLabel(label.id, { category: event.currentTarget.value.trim() });
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
  const here = state.timeline.value.rows.get(label.id)?.points[state.frame.value] ?? 0;
  const others = state.palette.value.filter(({ id, locked }) => id !== label.id && !locked);
  const may = canEdit.value && !label.locked;
  return (
    <>
      <button
        type="button"
        class="menu-item"
        disabled={!may || here === 0}
        data-tip="Each separate part in this frame gets its own label"
        onClick={() => {
          onClose();
          void actions.splitLabel(label.id);
        }}
      >
        <Icon name="split" /> Split into parts
      </button>
      <label class="menu-item">
        <Icon name="merge" />
        <select
          class="field"
          aria-label="Merge into"
          disabled={!may || others.length === 0}
          onChange={(event) => {
            onClose();
            void actions.mergeLabel(label.id, Number(event.currentTarget.value));
          }}
        >
          <option value="">Merge into…</option>
          {others.map(({ id, name }) => (
            <option key={id} value={id}>
              {name}
            </option>
          ))}
        </select>
      </label>
    </>
  );
}
