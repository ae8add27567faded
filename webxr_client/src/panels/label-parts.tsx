/** In a label's menu: make it part of another one, or split it. */
import { actions } from '../actions';
import type { Label } from '../protocol/messages';
import { canEdit, state } from '../state';
import { Icon } from './icon';

interface LabelPartsProps {
  label: Label;
  onClose: () => void;
}

export function LabelParts({ label, onClose }: LabelPartsProps) {
  const here = state.timeline.value.rows.get(label.id)?.points[state.frame.value] ?? 0;
  const others = state.palette.value.filter(({ id, locked }) => id !== label.id && !locked);
  const may = canEdit.value && !label.locked;
  return (
    <>
      <button
        type="button"
        class="menu-item"
        disabled={!may || here === 0}
        data-tip="Each part that stands apart in this frame gets a label of its own"
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
