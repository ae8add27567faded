/** The recording's name; opens the list of the others. */
import { signal } from '@preact/signals';
import { useCallback, useRef, useState } from 'preact/hooks';
import { matching } from '../../engine/recordings/list';
import { actions } from '../../store/actions';
import { canEdit, canManage, importJob, state, type SequenceSummary } from '../../store/state';
import { pickFiles } from './files';
import { plural, shortCount } from '../../common/format';
import { Icon } from '../../common/icons';
import { MenuItem, Popover } from '../parts/popover';
import { RecordingName, RecordingSearch, RecordingTools, renamingRecording } from './recordings';

const open = signal(false);
const close = (): void => {
  open.value = false;
};

export function SequenceMenu() {
  const anchor = useRef<HTMLButtonElement>(null);
  const toggle = useCallback(() => {
    open.value = !open.value;
    if (open.value) void actions.recordings.refreshSequences();
  }, []);
  const sequence = state.sequence.value;
  return (
    <>
      <h1 class="recording-title">
        <button
          ref={anchor}
          type="button"
          class="button sequence-button"
          aria-haspopup="dialog"
          aria-expanded={open.value}
          data-tip={sequence?.name ?? 'Recordings'}
          onClick={toggle}
        >
          <span class="name">{sequence?.name ?? 'Recordings'}</span>
          <Icon name="chevron" />
        </button>
      </h1>
      {open.value && (
        <Popover anchor={anchor} label="Recordings" onClose={close}>
          <Sequences />
          <hr />
          <MenuItem
            icon="import"
            label="Import files…"
            disabled={importJob.value !== null || !canManage.value}
            onClick={() => pickFiles()}
          />
          <MenuItem
            icon="plane"
            label="Set the floor…"
            disabled={!sequence || !canEdit.value}
            onClick={() => actions.tools.setTool('floor')}
          />
          <MenuItem
            icon="folder"
            label="All recordings"
            onClick={() => actions.recordings.closeSequence()}
          />
        </Popover>
      )}
    </>
  );
}

/** Most recordings in the list; a search finds the others. */
const LISTED = 40;

function Sequences() {
  const [text, setText] = useState('');
  const all = state.sequences.value ?? [];
  const found = matching(all, text);
  return (
    <>
      {all.length > LISTED && <RecordingSearch of={all} text={text} onInput={setText} />}
      <ul class="sequence-list">
        {found.slice(0, LISTED).map((row) => (
          <SequenceRow key={row.id} row={row} />
        ))}
        {found.length > LISTED && (
          <li class="soft">{found.length - LISTED} more: search, or see all recordings</li>
        )}
      </ul>
    </>
  );
}

function SequenceRow({ row }: { row: SequenceSummary }) {
  const current = state.sequence.value?.id === row.id;
  if (renamingRecording.value === row.id) {
    return (
      <li class="recording-line">
        <RecordingName row={row} />
      </li>
    );
  }
  return (
    <li class="recording-line">
      <button
        type="button"
        class="menu-item grow"
        aria-current={current}
        onClick={() => {
          close();
          if (!current) actions.recordings.openSequence(row.id);
        }}
      >
        <Icon name={current ? 'check' : 'points'} />
        <span class="name">{row.name}</span>
        <span class="end number">
          {plural(row.frames, 'frame')} · {shortCount(row.points)}
        </span>
      </button>
      <span class="recording-tools">
        <RecordingTools row={row} {...(current && { onDelete: close })} />
      </span>
    </li>
  );
}
