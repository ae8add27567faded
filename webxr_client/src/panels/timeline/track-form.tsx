/** Carrying labels through time: which, how far, how. */
import { signal, useComputed } from '@preact/signals';
import { useState } from 'preact/hooks';
import { trackableLabels } from '../../store/palette-list';
import { actions, type TrackRequest } from '../../store/actions';
import { patch, state } from '../../store/state';
import { Button, Check, Swatch } from '../parts/controls';
import { plural } from '../../common/format';
import { ChoiceRow } from '../parts/fields';
import { frameRange } from '../../store/range';

export const trackOpen = signal(false);
const close = (): void => {
  trackOpen.value = false;
};

const METHODS: readonly (readonly [string, string])[] = [
  ['auto', 'Automatic'],
  ['icp', 'Shape (ICP)'],
  ['color-icp', 'Shape and colour (colour ICP)'],
];

type Choices = Required<Omit<TrackRequest, 'labels' | 'start' | 'stop'>>;
type Switch = { [K in keyof Choices]: Choices[K] extends boolean ? K : never }[keyof Choices];

const OVERWRITE: readonly (readonly [Choices['overwrite'], string])[] = [
  ['tracked', 'Replace tracked points'],
  ['never', 'Keep all labels'],
  ['all', 'Replace painted points too'],
];

const SWITCHES: readonly (readonly [Switch, string, string])[] = [
  [
    'continue_lost',
    'Look for lost labels to the end',
    'Without this option, tracking of a label ends at the frame where it is lost',
  ],
  [
    'until_painted',
    'Only up to the next painted frame',
    'Frames after the next painted frame stay unchanged',
  ],
  ['stop_unsure', 'Stop at doubtful frames', 'Correct or confirm the frame, then continue from it'],
];

/** Kept from run to run. */
const choices = signal<Choices>({
  method: 'auto',
  overwrite: 'tracked',
  continue_lost: false,
  until_painted: false,
  stop_unsure: false,
});

export function TrackForm() {
  const last = (state.sequence.value?.frames ?? 1) - 1;
  const [start, setStart] = useState(frameRange.peek()?.from ?? state.frame.peek());
  const [stop, setStop] = useState(frameRange.peek()?.to ?? last);
  const available = useComputed(() => trackableLabels(start)).value;
  const [chosen, setChosen] = useState<ReadonlySet<number>>(() => initial(available));
  const labels = available.filter((id) => chosen.has(id));
  const submit = (event: Event): void => {
    event.preventDefault();
    actions.tracking.track({ labels, start, stop, ...choices.peek() });
    close();
  };
  return (
    <form onSubmit={submit}>
      <h2>Track labels</h2>
      <Painted frame={start} labels={available} chosen={chosen} onChange={setChosen} />
      <div class="track-range line">
        <FrameField label="From" value={start} max={last} onChange={setStart} />
        <FrameField label="To" value={stop} max={last} onChange={setStop} />
        <span class="soft">{inWords(start, stop)}</span>
      </div>
      <RunOptions />
      <div class="form-end">
        <Button label="Cancel" onClick={close} />
        <Button
          submit
          label={`Track ${labels.length > 0 ? plural(labels.length, 'label') : ''}`}
          kind="primary"
          disabled={labels.length === 0 || start === stop}
        />
      </div>
    </form>
  );
}

function inWords(start: number, stop: number): string {
  if (start === stop) return 'Choose another frame';
  return `${plural(Math.abs(stop - start), 'frame')} ${stop > start ? 'forward' : 'backward'}`;
}

/** The choices that every run has. */
function RunOptions() {
  const { method, overwrite } = choices.value;
  return (
    <>
      <ChoiceRow
        label="Method"
        value={method}
        choices={METHODS}
        onChange={(method) => patch(choices, { method })}
      />
      <ChoiceRow
        label="Overwrite"
        value={overwrite}
        choices={OVERWRITE}
        onChange={(overwrite) => patch(choices, { overwrite })}
      />
      <fieldset>
        {SWITCHES.map(([name, label, tip]) => (
          <Check
            key={name}
            label={label}
            tip={tip}
            checked={choices.value[name]}
            onChange={(on) => patch(choices, { [name]: on })}
          />
        ))}
      </fieldset>
    </>
  );
}

interface PaintedProps {
  frame: number;
  labels: readonly number[];
  chosen: ReadonlySet<number>;
  onChange: (chosen: ReadonlySet<number>) => void;
}

/** The labels that a run may carry on. */
function Painted({ frame, labels, chosen, onChange }: PaintedProps) {
  const toggle = (id: number): void => {
    const next = new Set(chosen);
    if (!next.delete(id)) next.add(id);
    onChange(next);
  };
  return (
    <fieldset>
      <legend>Painted in frame {frame}</legend>
      {labels.length === 0 && (
        <p class="soft">No label yet: paint an object in this frame first.</p>
      )}
      {labels.map((id) => (
        <LabelCheck key={id} id={id} checked={chosen.has(id)} onToggle={toggle} />
      ))}
    </fieldset>
  );
}

function initial(available: readonly number[]): ReadonlySet<number> {
  const active = state.activeLabel.peek();
  return new Set(available.includes(active) ? [active] : available);
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
    <label class="row">
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
