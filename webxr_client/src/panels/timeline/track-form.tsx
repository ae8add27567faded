/** Carrying labels through time: which, how far, how. */
import { signal, useComputed } from '@preact/signals';
import type { RefObject } from 'preact';
import { useState } from 'preact/hooks';
import { actions, type TrackRequest } from '../../store/actions';
import { state } from '../../store/state';
import { Button, Check, Swatch } from '../parts/controls';
import { plural } from '../../common/format';
import { Popover } from '../parts/popover';
import { frameRange } from '../../store/range';

export const trackOpen = signal(false);
const close = (): void => {
  trackOpen.value = false;
};

export const METHODS: readonly (readonly [string, string])[] = [
  ['auto', 'Automatic'],
  ['icp', 'Shape (ICP)'],
  ['color-icp', 'Shape and colour (colour ICP)'],
];

const OVERWRITE: readonly (readonly [TrackRequest['overwrite'], string])[] = [
  ['tracked', 'Replace tracked points'],
  ['never', 'Keep every label'],
  ['all', 'Replace painted points too'],
];

const method = signal('auto');
const overwrite = signal<TrackRequest['overwrite']>('tracked');
const continueLost = signal(false);
const untilPainted = signal(false);
const stopUnsure = signal(false);

export function TrackForm({ anchor }: { anchor: RefObject<HTMLElement | null> }) {
  const last = (state.sequence.value?.frames ?? 1) - 1;
  const [start, setStart] = useState(frameRange.peek()?.from ?? state.frame.peek());
  const [stop, setStop] = useState(frameRange.peek()?.to ?? last);
  const here = useComputed(() => labelsIn(start)).value;
  const [chosen, setChosen] = useState<ReadonlySet<number>>(() => initial(here));
  const labels = here.filter((id) => chosen.has(id));
  const submit = (event: Event): void => {
    event.preventDefault();
    actions.track({
      labels,
      start,
      stop,
      method: method.value,
      overwrite: overwrite.value,
      continue_lost: continueLost.value,
      until_painted: untilPainted.value,
      stop_unsure: stopUnsure.value,
    });
    close();
  };
  const toggle = (id: number): void => {
    const next = new Set(chosen);
    if (!next.delete(id)) next.add(id);
    setChosen(next);
  };
  return (
    <Popover anchor={anchor} label="Track labels" onClose={close} class="track-form">
      <form onSubmit={submit}>
        <h2>Track labels</h2>
        <fieldset>
          <legend>Painted in frame {start}</legend>
          {here.length === 0 && (
            <p class="soft">Nothing yet: paint an object in this frame first.</p>
          )}
          {here.map((id) => (
            <LabelCheck key={id} id={id} checked={chosen.has(id)} onToggle={toggle} />
          ))}
        </fieldset>
        <div class="track-range">
          <FrameField label="From" value={start} max={last} onChange={setStart} />
          <FrameField label="To" value={stop} max={last} onChange={setStop} />
          <span class="soft">
            {stop === start ? '' : `${plural(Math.abs(stop - start), 'frame')} `}
            {stop > start ? 'forward' : stop < start ? 'backward' : 'Choose another frame'}
          </span>
        </div>
        <label class="row">
          <span>Method</span>
          <select
            class="field"
            value={method.value}
            onChange={(event) => (method.value = event.currentTarget.value)}
          >
            {METHODS.map(([id, name]) => (
              <option key={id} value={id}>
                {name}
              </option>
            ))}
          </select>
        </label>
        <label class="row">
          <span>On the way</span>
          <select
            class="field"
            value={overwrite.value}
            onChange={(event) =>
              (overwrite.value = event.currentTarget.value as TrackRequest['overwrite'])
            }
          >
            {OVERWRITE.map(([id, name]) => (
              <option key={id} value={id}>
                {name}
              </option>
            ))}
          </select>
        </label>
        <fieldset>
          <Check
            label="Look for lost labels to the end"
            tip="A label that is lost ends there unless this is on"
            checked={continueLost.value}
            onChange={(on) => (continueLost.value = on)}
          />
          <Check
            label="Only up to the next painted frame"
            tip="What comes after a frame that you painted stays as it is"
            checked={untilPainted.value}
            onChange={(on) => (untilPainted.value = on)}
          />
          <Check
            label="Stop where it is unsure"
            tip="Mend or accept that frame, and let it go on from there"
            checked={stopUnsure.value}
            onChange={(on) => (stopUnsure.value = on)}
          />
        </fieldset>
        <div class="form-end">
          <Button label="Cancel" onClick={close} />
          <button
            type="submit"
            class="button primary"
            disabled={labels.length === 0 || start === stop}
          >
            Track {labels.length > 0 ? plural(labels.length, 'label') : ''}
          </button>
        </div>
      </form>
    </Popover>
  );
}

/** Labels with points in a frame, in the palette's order; locked ones cannot be tracked. */
export function labelsIn(frame: number): number[] {
  const { rows } = state.timeline.value;
  return state.palette.value
    .filter((label) => !label.locked && (rows.get(label.id)?.points[frame] ?? 0) > 0)
    .map((label) => label.id);
}

function initial(here: readonly number[]): ReadonlySet<number> {
  const active = state.activeLabel.peek();
  return new Set(here.includes(active) ? [active] : here);
}

interface LabelCheckProps {
  id: number;
  checked: boolean;
  onToggle: (id: number) => void;
}

function LabelCheck({ id, checked, onToggle }: LabelCheckProps) {
  const label = state.palette.value.find((entry) => entry.id === id);
  if (!label) return null;
  return (
    <label class="check">
      <input type="checkbox" checked={checked} onChange={() => onToggle(id)} />
      <Swatch color={label.color} />
      {label.name}
    </label>
  );
}

interface FrameFieldProps {
  label: string;
  value: number;
  max: number;
  onChange: (frame: number) => void;
}

function FrameField({ label, value, max, onChange }: FrameFieldProps) {
  return (
    <label>
      {label}
      <input
        class="field number"
        type="number"
        min={0}
        max={max}
        value={value}
        onInput={(event) => {
          const frame = event.currentTarget.valueAsNumber;
          if (Number.isInteger(frame) && frame >= 0 && frame <= max) onChange(frame);
        }}
      />
    </label>
  );
}
