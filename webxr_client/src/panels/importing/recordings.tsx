/** A recording in a list: picture, date, length, progress; rename and delete. */
import {
  deleteSequence,
  importSourceLabels,
  renameSequence,
} from '../../engine/recordings/recordings';
import { signal, useSignal } from '@preact/signals';
import { moveRecording, projects } from '../../engine/recordings/projects';
import { actions } from '../../store/actions';
import { apiUrl } from '../../net/rest';
import { canEdit, canManage, type SequenceSummary } from '../../store/state';
import { Button, NameField } from '../parts/controls';
import { MenuItem, PopoverButton } from '../parts/popover';
import { ago, clock, plural, shortCount } from '../../common/format';
import { Icon } from '../../common/icons';

/** A row of the table: its cells are in the order of the column headings of `home.tsx`. */
export function Row({ row }: { row: SequenceSummary }) {
  const sound = row.damaged === null;
  const fault = sound ? labelsMissing(row) : `Damaged: ${row.damaged}`;
  const path = `sequences/${encodeURIComponent(row.id)}/frames/0/thumbnail`;
  return (
    <>
      <button
        type="button"
        class="recording grow small"
        disabled={!sound}
        onClick={() => actions.recordings.openSequence(row.id)}
      >
        {sound && row.frames > 0 ? (
          <img src={`${apiUrl(path)}?of=${row.identity ?? ''}`} alt="" loading="lazy" />
        ) : (
          <Icon name="warning" />
        )}
        <strong class="name" data-tip={row.name}>
          {row.name}
        </strong>
        {fault ? <span class="recording-fault warn">{fault}</span> : <Figures row={row} />}
      </button>
      <span class="recording-tools">
        {sound && row.labels_missing !== null && canEdit.value && (
          <Button
            label="Try again"
            tip={`Import the labels in the files of ${row.name}`}
            small
            onClick={() => void importSourceLabels(row.id)}
          />
        )}
        <MoveTo row={row} />
        <RecordingTools row={row} />
      </span>
    </>
  );
}

function labelsMissing({ labels_missing: reason }: SequenceSummary): string {
  return reason === null ? '' : `Labels were not imported: ${reason}`;
}

/** Length, size, labels and date. Frames and labels with points do not mean that all is done. */
function Figures({ row }: { row: SequenceSummary }) {
  const { frames, fps, labelled, labels, labels_used: used, changed } = row;
  const long = fps > 0 && frames > 1 ? ` · ${clock(frames / fps)}` : '';
  return (
    <>
      <span class="soft number">{plural(frames, 'frame') + long}</span>
      <span class="soft number">{shortCount(row.points)}</span>
      <span class="line soft number">
        <span class="progress" aria-hidden="true">
          <span style={{ width: `${(100 * labelled) / Math.max(1, frames)}%` }} />
        </span>
        {labelled} of {plural(frames, 'frame')}
      </span>
      <span class="soft number">{labels > 0 && `${used} of ${labels}`}</span>
      <span class="soft">{changed !== null && <When iso={changed} />}</span>
    </>
  );
}

function When({ iso }: { iso: string }) {
  return (
    <time dateTime={iso} data-tip={new Date(iso).toLocaleString()}>
      {ago(iso)}
    </time>
  );
}

/** Puts it into another project, where there are several. */
function MoveTo({ row }: { row: SequenceSummary }) {
  const open = useSignal(false);
  const others = projects.value.filter(({ id }) => id !== row.project);
  if (others.length === 0 || !canManage.value) return null;
  return (
    <PopoverButton
      open={open}
      icon="folder"
      tip={`Move ${row.name} to another project`}
      label="Move to"
      small
    >
      {others.map(({ id, name }) => (
        <MenuItem key={id} label={name} onClick={() => void moveRecording(row.id, id)} />
      ))}
    </PopoverButton>
  );
}

/** Id of the recording that is being renamed. */
export const renamingRecording = signal<string | null>(null);

interface RecordingToolsProps {
  row: SequenceSummary;
  /** It is about to be deleted. */
  onDelete?: () => void;
}

export function RecordingTools({ row, onDelete }: RecordingToolsProps) {
  if (!canManage.value) return null;
  return (
    <>
      <Button
        icon="pencil"
        tip={`Rename ${row.name}`}
        small
        onClick={() => (renamingRecording.value = row.id)}
      />
      <Button
        icon="trash"
        tip={`Delete ${row.name}; it can be restored for 30 days`}
        small
        onClick={() => {
          onDelete?.();
          void deleteSequence(row.id);
        }}
      />
    </>
  );
}

interface RecordingSearchProps {
  of: readonly SequenceSummary[];
  text: string;
  onInput: (text: string) => void;
}

export function RecordingSearch({ of, text, onInput }: RecordingSearchProps) {
  return (
    <input
      class="field sequence-search"
      type="search"
      aria-label="Search the recordings"
      placeholder={`Search ${plural(of.length, 'recording')}`}
      value={text}
      onInput={(event) => onInput(event.currentTarget.value)}
    />
  );
}

/** The name's field, in the place of the row. */
export function RecordingName({ row }: { row: SequenceSummary }) {
  return (
    <NameField
      name={row.name}
      maxLength={200}
      onFinish={(name) => {
        renamingRecording.value = null;
        if (name && name !== row.name) void renameSequence(row.id, name);
      }}
    />
  );
}
