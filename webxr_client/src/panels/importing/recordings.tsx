/** A recording in a list: picture, date, length, progress; rename and delete. */
import { signal, useSignal } from '@preact/signals';
import { moveRecording, projects } from '../../engine/projects';
import { actions } from '../../store/actions';
import { apiUrl } from '../../net/rest';
import { canEdit, canManage, type SequenceSummary } from '../../store/state';
import { Button, NameField } from '../parts/controls';
import { PopoverButton } from '../parts/popover';
import { clock, day, plural, shortCount } from '../../common/format';
import { Icon } from '../../common/icons';

/** Return the recordings whose names have all words, in any order. */
export function matching(
  sequences: readonly SequenceSummary[],
  text: string,
): readonly SequenceSummary[] {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  return sequences.filter(({ name, id }) => {
    const told = `${name} ${id}`.toLowerCase();
    return words.every((word) => told.includes(word));
  });
}

export function Row({ row }: { row: SequenceSummary }) {
  const sound = row.damaged === null;
  const path = `sequences/${encodeURIComponent(row.id)}/frames/0/thumbnail`;
  return (
    <>
      <button
        type="button"
        class="recording"
        disabled={!sound}
        onClick={() => actions.openSequence(row.id)}
      >
        {sound && row.frames > 0 ? (
          <img src={`${apiUrl(path)}?of=${row.identity ?? ''}`} alt="" loading="lazy" />
        ) : (
          <Icon name="warning" />
        )}
        <span class="recording-words">
          <strong class="name">{row.name}</strong>
          {sound ? <Length row={row} /> : <span class="soft">Damaged: {row.damaged}</span>}
          {sound && row.labels_missing !== null && (
            <span class="soft">Labels were not imported: {row.labels_missing}</span>
          )}
        </span>
        {sound && row.labels_missing === null && <Labelled row={row} />}
        <Icon name="next" />
      </button>
      {sound && row.labels_missing !== null && canEdit.value && (
        <Button
          label="Try again"
          tip={`Import the labels in the files of ${row.name}`}
          small
          onClick={() => void actions.importSourceLabels(row.id)}
        />
      )}
      <MoveTo row={row} />
      <RecordingTools row={row} />
    </>
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
        <button
          key={id}
          type="button"
          class="menu-item"
          onClick={() => {
            open.value = false;
            void moveRecording(row.id, id);
          }}
        >
          {name}
        </button>
      ))}
    </PopoverButton>
  );
}

function Length({ row }: { row: SequenceSummary }) {
  return (
    <span class="soft number">
      {plural(row.frames, 'frame')}
      {row.fps > 0 && row.frames > 1 ? ` · ${clock(row.frames / row.fps)}` : ''} ·{' '}
      {shortCount(row.points)} points
      {row.created !== null && ` · ${day(row.created)}`}
    </span>
  );
}

/** Frames and labels that have points, of all: neither says that the work is done. */
function Labelled({ row }: { row: SequenceSummary }) {
  return (
    <span class="recording-progress">
      <Part done={row.labelled} of={row.frames} what="frames" />
      {row.labels > 0 && <Part done={row.labels_used} of={row.labels} what="labels" />}
    </span>
  );
}

function Part({ done, of, what }: { done: number; of: number; what: string }) {
  return (
    <span class="part">
      <span class="soft number">
        {done} of {of} {what}
      </span>
      <span class="progress" aria-hidden="true">
        <span style={{ transform: `scaleX(${of > 0 ? done / of : 0})` }} />
      </span>
    </span>
  );
}

/** The recording whose name is being typed. */
export const renamingRecording = signal<string | null>(null);

interface RecordingToolsProps {
  row: SequenceSummary;
  /** It is about to be deleted. */
  onDelete?: () => void;
}

export function RecordingTools({ row, onDelete }: RecordingToolsProps) {
  if (!canManage.value) return null;
  return (
    <span class="recording-tools">
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
          void actions.deleteSequence(row.id);
        }}
      />
    </span>
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
        if (name && name !== row.name) void actions.renameSequence(row.id, name);
      }}
    />
  );
}
