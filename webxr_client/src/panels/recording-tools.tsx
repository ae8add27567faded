/** Rare actions on a recording of a list: rename, delete. */
import { signal } from '@preact/signals';
import { actions } from '../actions';
import { canManage, type SequenceSummary } from '../state';
import { Button } from './controls';
import { NameField } from './name-field';

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
