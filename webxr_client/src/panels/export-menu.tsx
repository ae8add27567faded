/** Downloads. */
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { actions } from '../store/actions';
import { exportFormats, type ExportFormat } from '../engine/recordings';
import { state } from '../store/state';
import { Check } from './parts/controls';
import { frameRange, ordered } from '../store/range';
import { PopoverButton } from './parts/popover';

export const exportOpen = signal(false);
const onlyRange = signal(true);
/** Frames for validation in formats for training: a range, "none", or empty for the default. */
const validation = signal('');

export function ExportButton() {
  return (
    <PopoverButton
      open={exportOpen}
      icon="export"
      button={{ label: 'Export', class: 'export-button' }}
      tip="Download points and labels"
      label="Export"
      class="export-menu"
    >
      <ExportMenu />
    </PopoverButton>
  );
}

function ExportMenu() {
  const range = frameRange.value && ordered(frameRange.value);
  const frames = range && onlyRange.value ? `${range[0]}:${range[1] + 1}` : '';
  useEffect(() => void actions.loadExportFormats(), []);
  const start = (format: string, judged = ''): void => {
    exportOpen.value = false;
    void actions.exportSequence(format, frames, judged);
  };
  // Of an export of the range alone it would be everything.
  const stretch = range && !frames ? `${range[0]}:${range[1] + 1}` : '';
  const chosen = validation.value;
  const val = ['none', ':', stretch].includes(chosen) ? chosen : '';
  const all = state.sequence.value?.frames ?? 0;
  return (
    <>
      <h2>Export {frames ? `frames ${range![0]} – ${range![1]}` : `all ${all} frames`}</h2>
      {range && (
        <Check
          label="Only the chosen range"
          checked={onlyRange.value}
          onChange={(checked) => (onlyRange.value = checked)}
        />
      )}
      <Formats formats={exportFormats.value.filter((each) => !each.splits)} start={start} />
      <label class="row">
        <span>Validation</span>
        <select
          class="field"
          value={val}
          onChange={(event) => (validation.value = event.currentTarget.value)}
        >
          <option value="">one recording in five</option>
          <option value="none">none of these frames</option>
          <option value=":">all of these frames</option>
          {stretch && <option value={stretch}>the chosen range</option>}
        </select>
      </label>
      <Formats
        formats={exportFormats.value.filter((each) => each.splits)}
        start={(format) => start(format, val)}
      />
    </>
  );
}

interface FormatsProps {
  formats: readonly ExportFormat[];
  start: (format: string) => void;
}

function Formats({ formats, start }: FormatsProps) {
  return (
    <>
      {formats.map(({ format, title, content, cannot_hold }) => (
        <button
          key={format}
          type="button"
          class="menu-item export-format"
          onClick={() => start(format)}
        >
          {title}
          <span class="end">{content}</span>
          {cannot_hold.length > 0 && <small>without {cannot_hold.join(', ')}</small>}
        </button>
      ))}
    </>
  );
}
