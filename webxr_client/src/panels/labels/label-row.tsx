/** One label: its colour, name, counts and actions. */
import type { RefObject } from 'preact';
import { useRef, useState } from 'preact/hooks';
import { actions } from '../../store/actions';
import type { Label } from '../../protocol/messages';
import { canEdit, state } from '../../store/state';
import { labelColours } from '../../store/safe-colours';
import { Button, NameField } from '../parts/controls';
import { shortCount } from '../../common/format';
import { Icon } from '../../common/icons';
import { lossOf, pointsOf } from './label-points';
import { dragged, onRowDown, onRowFocus, onRowKey, tabStop } from './label-rows';
import { LabelMenu } from './label-menu';
import { keyOf, menuOf, renaming } from '../../store/palette-list';
import { CutName } from '../parts/cut-name';
import { Popover } from '../parts/popover';

export function LabelRow({ label, number }: { label: Label; number: number }) {
  const menu = menuOf.value === label.id;
  const setMenu = (open: boolean): void => void (menuOf.value = open ? label.id : null);
  const more = useRef<HTMLButtonElement>(null);
  const active = state.activeLabel.value === label.id;
  const solo = state.solo.value === label.id;
  const dimmed = !label.visible || (state.solo.value !== null && !solo);
  const editing = renaming.value === label.id;
  const key = keyOf(number);
  const choose = (): void => actions.labels.selectLabel(label.id);
  return (
    <div
      class={`label-row${dimmed ? ' dimmed' : ''}`}
      data-label={label.id}
      data-drop={dropOf(label.id)}
      role="row"
      aria-selected={active}
      aria-label={label.name}
      tabIndex={tabStop.value === label.id ? 0 : -1}
      onPointerDown={(event) => onRowDown(event, label.id)}
      onClick={choose}
      onContextMenu={(event) => {
        event.preventDefault();
        choose();
        setMenu(true);
      }}
      onDblClick={() => canEdit.peek() && (renaming.value = label.id)}
      onKeyDown={(event) => onRowKey(event, label.id)}
      onFocusIn={() => onRowFocus(label.id)}
    >
      <span role="gridcell">
        <ColorButton label={label} />
      </span>
      <div class="lines" role="gridcell">
        <LabelText label={label} />
      </div>
      {!editing && <LabelState label={label} solo={solo} />}
      <div class="label-tools" role="gridcell">
        <Toggles label={label} solo={solo} />
        <Button
          buttonRef={more}
          icon="more"
          tip={`More for ${label.name}`}
          small
          tabIndex={-1}
          expanded={menu}
          onClick={(event) => {
            event.stopPropagation();
            setMenu(!menu);
          }}
        />
      </div>
      <span role="gridcell">{key && <span class="kbd">{key}</span>}</span>
      {menu && <LabelMenu label={label} anchor={more} onClose={() => setMenu(false)} />}
    </div>
  );
}

function LabelText({ label }: { label: Label }) {
  if (renaming.value === label.id) {
    return <NameField name={label.name} onFinish={(name) => rename(label, name)} />;
  }
  return (
    <>
      <CutName name={label.name} />
      {label.category && label.category !== label.name && (
        <span class="category name faint">{label.category}</span>
      )}
    </>
  );
}

interface SoloProps {
  label: Label;
  solo: boolean;
}

function LabelState({ label, solo }: SoloProps) {
  return (
    <span class="label-state line" role="gridcell">
      {label.locked && <Icon name="lock" />}
      {!label.visible && <Icon name="hidden" />}
      {solo && <Icon name="solo" />}
      <Counts id={label.id} />
    </span>
  );
}

function Toggles({ label, solo }: SoloProps) {
  return (
    <>
      <Toggle
        on={label.locked}
        icon={label.locked ? 'lock' : 'unlock'}
        tip={label.locked ? 'Unlock' : 'Lock: its points cannot be changed'}
        disabled={!canEdit.value}
        onClick={() => void actions.labels.toggleLock(label.id)}
      />
      <Toggle
        on={!label.visible}
        icon={label.visible ? 'eye' : 'hidden'}
        tip={label.visible ? 'Hide' : 'Show'}
        onClick={() => void actions.labels.toggleVisible(label.id)}
      />
      <Toggle
        on={solo}
        icon="solo"
        tip={solo ? 'Show all labels' : 'Show only this label'}
        onClick={() => actions.labels.solo(solo ? null : label.id)}
      />
    </>
  );
}

/** State of a row while one is dragged: it is the one, or the one comes before it. */
function dropOf(id: number): string | undefined {
  const at = dragged.value;
  if (at?.id === id) return 'moves';
  return at?.before === id ? 'before' : undefined;
}

function rename(label: Label, name: string | null): void {
  renaming.value = null;
  if (name && name !== label.name) void actions.labels.renameLabel(label.id, name);
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
        tabIndex={-1}
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

/** Points in this frame over points in all frames, as explained in the head of the list. */
function Counts({ id }: { id: number }) {
  const { inFrame, all } = pointsOf(id);
  return (
    <span class="counts number" data-tip={lossOf(id).join(', ')}>
      <b>{shortCount(inFrame)}</b>
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
    <Button
      icon={icon}
      tip={tip}
      small
      tabIndex={-1}
      pressed={on}
      disabled={disabled}
      onClick={(event) => {
        event.stopPropagation();
        onClick();
      }}
    />
  );
}

/** The colour set, and any other colour. */
interface ColorPickerProps {
  label: Label;
  anchor: RefObject<HTMLElement | null>;
  onClose: () => void;
}

function ColorPicker({ label, anchor, onClose }: ColorPickerProps) {
  const taken = new Set(
    state.palette.value.filter((other) => other.id !== label.id).map((other) => other.color),
  );
  const choose = (color: string): void => {
    onClose();
    if (color !== label.color) void actions.labels.recolorLabel(label.id, color);
  };
  return (
    <Popover anchor={anchor} label={`Colour of ${label.name}`} onClose={onClose}>
      <div class="color-grid">
        {labelColours.value.map((color) => (
          <button
            key={color}
            type="button"
            class="color-choice"
            style={{ '--color': color }}
            aria-label={color}
            aria-pressed={color === label.color}
            data-taken={taken.has(color) || undefined}
            data-tip={taken.has(color) ? 'Another label has this colour' : undefined}
            onClick={() => choose(color)}
          />
        ))}
      </div>
      <label class="row">
        <span>Other</span>
        <input
          type="color"
          value={label.color}
          onChange={(event) => choose(event.currentTarget.value)}
        />
      </label>
    </Popover>
  );
}
