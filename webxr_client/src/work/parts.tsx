/** Pieces of the Work panel: entries of a list, notes with their pin, fields of a form, tables. */
import type { ComponentChildren } from 'preact';
import { Icon, type IconName } from '../common/icons';
import { Button } from '../panels/parts/controls';
import type { Place } from './model';
import { pointing } from './places';

interface EntryProps {
  icon?: IconName;
  current?: boolean;
  /** The second line. */
  about: ComponentChildren;
  onClick: () => void;
  /** Buttons below or beside it. */
  actions?: ComponentChildren;
  children: ComponentChildren;
}

/** An entry of a list: a click goes to it. */
export function Entry({ icon, current = false, about, onClick, actions, children }: EntryProps) {
  return (
    <li data-current={current || undefined}>
      <button
        type="button"
        class="menu-item start"
        aria-current={current ? 'true' : undefined}
        onClick={onClick}
      >
        {icon && <Icon name={icon} />}
        <span class="lines">
          {children}
          <span class="soft">{about}</span>
        </span>
      </button>
      {actions}
    </li>
  );
}

interface Note {
  readonly note: string;
  readonly place: Place | null;
}

interface NoteFieldProps extends Note {
  onChange: (patch: Partial<Note>) => void;
}

/** Id of the field of a note, which commands give the focus. */
export const NOTE = 'work-note';

/** A note, and the place of it: the next click in the cloud gives it. */
export function NoteField({ note, place, onChange }: NoteFieldProps) {
  const waits = pointing.value !== null;
  const point = (): void => {
    pointing.value = waits ? null : (at) => onChange({ place: at });
  };
  return (
    <>
      <label>
        Note
        <textarea
          id={NOTE}
          class="field"
          rows={2}
          maxLength={2000}
          value={note}
          placeholder="Describe the correction"
          onInput={(event) => onChange({ note: event.currentTarget.value })}
        />
      </label>
      <div class="group">
        <Button
          icon="target"
          label={waits ? 'Click the place…' : place ? 'Pinned: change the place' : 'Pin to a place'}
          kind="outlined"
          small
          pressed={waits}
          onClick={point}
        />
        {place && (
          <Button
            icon="close"
            tip="Remove the pin"
            small
            onClick={() => onChange({ place: null })}
          />
        )}
      </div>
    </>
  );
}
