/** Downloads. */
import { exportSequence, loadExportFormats } from '../engine/recordings/recordings';
import type { ExportFormat } from '../protocol/values';
import { computed, signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { plural } from '../common/format';
import { Icon } from '../common/icons';
import { boxes } from '../store/boxes';
import { menuOf, search } from '../store/palette-list';
import { state } from '../store/state';
import { ExportFormats } from './export-formats';
import { ChoiceRow } from './parts/fields';
import { Button } from './parts/controls';
import { frameRange, ordered } from '../store/range';
import { exportOpen, PopoverButton } from './parts/popover';

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
  useEffect(() => void loadExportFormats(), []);
  // An export of only the range contains nothing but the range.
  const stretch = range && !frames ? `${range[0]}:${range[1] + 1}` : '';
  const chosen = validation.value;
  const val = ['none', ':', stretch].includes(chosen) ? chosen : '';
  const start = ({ format, splits }: ExportFormat): void => {
    exportOpen.value = false;
    void exportSequence(format, frames, splits ? val : '');
  };
  const all = state.sequence.value?.frames ?? 0;
  return (
    <>
      <h2>Export {frames ? `frames ${range![0]} – ${range![1]}` : `all ${all} frames`}</h2>
      <Range all={all} range={frames ? range : null} />
      <WithoutCategory />
      <ExportFormats split={<Validation value={val} range={stretch} />} start={start} />
    </>
  );
}

/** Used labels without a category: in formats with classes, each of them becomes a class. */
const uncategorised = computed(() => {
  const boxed = new Set([...boxes.value.values()].map(({ label }) => label));
  const used = (id: number): boolean => boxed.has(id) || (state.counts.value.get(id) ?? 0) > 0;
  return state.palette.value.filter(({ id, category }) => !category && used(id));
});
/** Labels without a category that have a button; the others are counted. */
const MOST_BUTTONS = 5;

function WithoutCategory() {
  const labels = uncategorised.value;
  if (labels.length === 0) return null;
  const more = labels.length - MOST_BUTTONS;
  return (
    <div class="note warn line start small">
      <Icon name="warning" />
      <div>
        {plural(labels.length, 'label')} without a category: training sets and boxes use the name as
        a class. Set the category of{' '}
        {labels.slice(0, MOST_BUTTONS).map(({ id, name }) => (
          <Button key={id} label={name} small onClick={() => setCategory(id)} />
        ))}
        {more > 0 && ` and ${more} more`}
      </div>
    </div>
  );
}

/** Open the menu of a label, which begins with its category. */
function setCategory(id: number): void {
  exportOpen.value = false;
  search.value = '';
  document.querySelector(`#palette [data-label="${id}"]`)?.scrollIntoView({ block: 'nearest' });
  menuOf.value = id;
}

interface ValidationProps {
  /** As the server reads it: a range, "none", or empty for the default. */
  value: string;
  /** The range chosen on the timeline, or empty. */
  range: string;
}

const VALIDATION = [
  ['', 'one recording in five'],
  ['none', 'none of these frames'],
  [':', 'all of these frames'],
] as const;

function Validation({ value, range }: ValidationProps) {
  return (
    <ChoiceRow
      label="Validation"
      value={value}
      choices={range ? [...VALIDATION, [range, 'the selected range']] : VALIDATION}
      onChange={(chosen) => (validation.value = chosen)}
    />
  );
}

interface RangeProps {
  all: number;
  /** null: all frames. */
  range: readonly [number, number] | null;
}

/** From which frame to which: the range chosen on the timeline, which these choose too. */
function Range({ all, range }: RangeProps) {
  const [from, to] = range ?? [0, all - 1];
  const choose = (first: number, last: number): void => {
    const within = (frame: number): number => Math.min(all - 1, Math.max(0, Math.round(frame)));
    onlyRange.value = true;
    frameRange.value = { from: within(Math.min(first, last)), to: within(Math.max(first, last)) };
  };
  const field = (label: string, value: number, change: (value: number) => void) => (
    <label class="row">
      {label}
      <input
        class="field"
        type="number"
        min={0}
        max={all - 1}
        value={value}
        onKeyDown={(event) => event.key !== 'Escape' && event.stopPropagation()}
        onChange={({ currentTarget: { value: text } }) => text && change(Number(text))}
      />
    </label>
  );
  return (
    <div class="track-range line">
      {field('Frames', from, (value) => choose(value, Math.max(value, to)))}
      {field('to', to, (value) => choose(Math.min(from, value), value))}
      {range && (
        <Button label="All" tip="Export all frames" onClick={() => (onlyRange.value = false)} />
      )}
    </div>
  );
}
