/** Downloads. */
import { signal } from '@preact/signals';
import type { RefObject } from 'preact';
import { actions } from '../actions';
import { state } from '../state';
import { Check } from './controls';
import { frameRange, ordered } from './range';
import { Popover } from './popover';

/** Formats by what one does with them. */
const FORMATS: readonly (readonly [format: string, name: string, what: string])[] = [
  ['ply', 'PLY', 'points and labels'],
  ['npz', 'NPZ', 'numpy arrays'],
  ['semantickitti', 'SemanticKITTI', '.bin and .label'],
  ['pcd', 'PCD', 'points and labels'],
  ['las', 'LAS', 'points, labels, own fields'],
  ['laz', 'LAZ', 'the same, compressed'],
  ['csv', 'CSV', 'one row per point'],
  ['labels-only', 'Labels only', 'no points'],
  ['cut', 'Cut', 'a file per label'],
  ['pointcept', 'Pointcept', 'scenes for training'],
  ['openpcdet', 'OpenPCDet', 'points and boxes'],
  ['boxes', 'Boxes', 'oriented boxes per frame'],
];

const onlyRange = signal(true);

interface ExportMenuProps {
  anchor: RefObject<HTMLElement | null>;
  onClose: () => void;
}

export function ExportMenu({ anchor, onClose }: ExportMenuProps) {
  const range = frameRange.value && ordered(frameRange.value);
  const frames = range && onlyRange.value ? `${range[0]}:${range[1] + 1}` : '';
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
      {FORMATS.map(([format, name, what]) => (
        <button
          key={format}
          type="button"
          class="menu-item"
          onClick={() => {
            onClose();
            void actions.exportSequence(format, frames);
          }}
        >
          {name}
          <span class="end">{what}</span>
        </button>
      ))}
    </Popover>
  );
}
