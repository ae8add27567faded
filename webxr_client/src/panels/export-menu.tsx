/** Downloads. */
import { signal } from '@preact/signals';
import type { RefObject } from 'preact';
import { useEffect } from 'preact/hooks';
import { actions } from '../actions';
import { exportFormats } from '../engine/recordings';
import { state } from '../state';
import { Check } from './controls';
import { frameRange, ordered } from './range';
import { Popover } from './popover';

const onlyRange = signal(true);

interface ExportMenuProps {
  anchor: RefObject<HTMLElement | null>;
  onClose: () => void;
}

export function ExportMenu({ anchor, onClose }: ExportMenuProps) {
  const range = frameRange.value && ordered(frameRange.value);
  const frames = range && onlyRange.value ? `${range[0]}:${range[1] + 1}` : '';
  useEffect(() => void actions.loadExportFormats(), []);
  const all = state.sequence.value?.frames ?? 0;
  return (
    <Popover anchor={anchor} label="Export" onClose={onClose} class="export-menu">
      <h2>Export {frames ? `frames ${range![0]} – ${range![1]}` : `all ${all} frames`}</h2>
      {range && (
        <Check
          label="Only the chosen range"
          checked={onlyRange.value}
          onChange={(checked) => (onlyRange.value = checked)}
        />
      )}
      {exportFormats.value.map(({ format, title, content, cannot_hold }) => (
        <button
          key={format}
          type="button"
          class="menu-item export-format"
          onClick={() => {
            onClose();
            void actions.exportSequence(format, frames);
          }}
        >
          {title}
          <span class="end">{content}</span>
          {cannot_hold.length > 0 && <small>without {cannot_hold.join(', ')}</small>}
        </button>
      ))}
    </Popover>
  );
}
