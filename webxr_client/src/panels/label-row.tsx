/** One label: its colour, name and counts, and what can be done with it. */
import { useRef, useState } from 'preact/hooks';
import { actions } from '../actions';
import type { Label } from '../protocol/messages';
import { canEdit, state } from '../state';
import { ColorPicker } from './color-picker';
import { Button } from './controls';
import { count, plural, shortCount } from './format';
import { Icon } from './icon';
import { LabelMenu } from './label-menu';
import { NameField } from './name-field';
import { renaming } from './renaming';

const NUMBER_KEYS = 9;

export function LabelRow({ label, number }: { label: Label; number: number }) {
  const [menu, setMenu] = useState(false);
  const more = useRef<HTMLButtonElement>(null);
  const active = state.activeLabel.value === label.id;
  const solo = state.solo.value === label.id;
  const dimmed = !label.visible || (state.solo.value !== null && !solo);
  const editing = renaming.value === label.id;
  const choose = (): void => actions.selectLabel(label.id);
  return (
    <li
      class={`label-row${dimmed ? ' dimmed' : ''}`}
      role="option"
      aria-selected={active}
      aria-label={label.name}
      tabIndex={0}
      onClick={choose}
      onDblClick={() => canEdit.peek() && (renaming.value = label.id)}
      onKeyDown={(event) => onKey(event, label.id)}
    >
      <ColorButton label={label} />
      <div class="label-text">
        {editing ? (
          <NameField name={label.name} onFinish={(name) => rename(label, name)} />
        ) : (
          <span class="name">{label.name}</span>
        )}
        {!editing && label.category && <span class="category">{label.category}</span>}
      </div>
      {!editing && (
        <span class="label-state">
          {label.locked && <Icon name="lock" />}
          {!label.visible && <Icon name="hidden" />}
          {solo && <Icon name="solo" />}
          <Counts id={label.id} />
        </span>
      )}
      <div class="label-tools">
        <Toggle
          on={label.locked}
          icon={label.locked ? 'lock' : 'unlock'}
          tip={label.locked ? 'Unlock' : 'Lock: its points cannot be changed'}
          disabled={!canEdit.value}
          onClick={() => void actions.toggleLock(label.id)}
        />
        <Toggle
          on={!label.visible}
          icon={label.visible ? 'eye' : 'hidden'}
          tip={label.visible ? 'Hide' : 'Show'}
          onClick={() => void actions.toggleVisible(label.id)}
        />
        <Toggle
          on={solo}
          icon="solo"
          tip={solo ? 'Show all labels' : 'Show only this label'}
          onClick={() => actions.solo(solo ? null : label.id)}
        />
        <Button
          buttonRef={more}
          icon="more"
          tip={`More for ${label.name}`}
          small
          expanded={menu}
          onClick={(event) => {
            event.stopPropagation();
            setMenu(!menu);
          }}
        />
      </div>
      {number <= NUMBER_KEYS ? <span class="kbd">{number}</span> : <span />}
      {menu && <LabelMenu label={label} anchor={more} onClose={() => setMenu(false)} />}
    </li>
  );
}

function rename(label: Label, name: string | null): void {
  renaming.value = null;
  if (name && name !== label.name) void actions.renameLabel(label.id, name);
}

function onKey(event: KeyboardEvent, id: number): void {
  if (event.target !== event.currentTarget) return;
  const row = event.currentTarget as HTMLElement;
  if (event.key === 'Enter') actions.selectLabel(id);
  else if (event.key === 'F2') renaming.value = id;
  else if (event.key === 'ArrowDown') (row.nextElementSibling as HTMLElement | null)?.focus();
  else if (event.key === 'ArrowUp') (row.previousElementSibling as HTMLElement | null)?.focus();
  else return;
  event.preventDefault();
  event.stopPropagation();
}

function ColorButton({ label }: { label: Label }) {
  const [open, setOpen] = useState(false);
  const anchor = useRef<HTMLButtonElement>(null);
  return (
    <>
      <button
        ref={anchor}
        type="button"
        class="color-button"
        style={{ '--color': label.color }}
        aria-label={`Colour of ${label.name}`}
        data-tip="Change the colour"
        disabled={!canEdit.value}
        onClick={(event) => {
          event.stopPropagation();
          setOpen(!open);
        }}
      />
      {open && <ColorPicker label={label} anchor={anchor} onClose={() => setOpen(false)} />}
    </>
  );
}

/** Points in this frame over points in all frames. */
function Counts({ id }: { id: number }) {
  const here = state.timeline.value.rows.get(id)?.points[state.frame.value] ?? 0;
  const all = state.counts.value.get(id) ?? 0;
  return (
    <span
      class="counts number"
      data-tip={`${plural(here, 'point')} in this frame, ${count(all)} in all`}
    >
      <b>{shortCount(here)}</b>
      <span class="faint">{shortCount(all)}</span>
    </span>
  );
}

interface ToggleProps {
  on: boolean;
  icon: 'lock' | 'unlock' | 'eye' | 'hidden' | 'solo';
  tip: string;
  disabled?: boolean;
  onClick: () => void;
}

function Toggle({ on, icon, tip, disabled, onClick }: ToggleProps) {
  return (
    <button
      type="button"
      class="button icon-only small"
      aria-label={tip}
      aria-pressed={on}
      data-tip={tip}
      disabled={disabled}
      onClick={(event) => {
        event.stopPropagation();
        onClick();
      }}
    >
      <Icon name={icon} />
    </button>
  );
}
