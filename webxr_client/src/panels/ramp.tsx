/** Legend and range of a colour ramp: the part of the values that it spans, what colours mean. */
import { signal } from '@preact/signals';
import { useRef } from 'preact/hooks';
import { actions } from '../actions';
import { BETWEEN, PAINTED, SURE, TRACKED, UNKNOWN, UNSURE } from '../engine/colouring';
import { state, type ColorMode, type Ramp } from '../state';
import { Button, Slider, Swatch } from './controls';
import { Popover } from './popover';

const open = signal(false);

const RAMPS: readonly (readonly [Ramp, string])[] = [
  ['even', 'Even'],
  ['grey', 'Grey'],
  ['rainbow', 'Rainbow'],
];

type Legend = readonly (readonly [colour: string, meaning: string])[];

const LEGENDS: Partial<Record<ColorMode, Legend>> = {
  confidence: [
    [SURE, 'sure, or painted'],
    [BETWEEN, 'between'],
    [UNSURE, 'doubtful'],
    [UNKNOWN, 'not tracked here'],
  ],
  provenance: [
    [PAINTED, 'painted'],
    [TRACKED, 'tracked'],
    [UNKNOWN, 'not in this frame'],
  ],
};
const RAMPED: readonly ColorMode[] = ['intensity', 'height', 'distance'];

export function RampButton() {
  const anchor = useRef<HTMLButtonElement>(null);
  const { color } = state.view.value;
  const legend = LEGENDS[color];
  if (!legend && !RAMPED.includes(color)) return null;
  return (
    <>
      <Button
        buttonRef={anchor}
        icon="more"
        tip={legend ? 'What the colours mean' : 'Ramp and range of the colours'}
        expanded={open.value}
        onClick={() => (open.value = !open.value)}
      />
      {open.value && (
        <Popover
          anchor={anchor}
          label="Colours"
          onClose={() => (open.value = false)}
          class="overlays"
        >
          {legend ? <Meanings legend={legend} /> : <RampOptions />}
        </Popover>
      )}
    </>
  );
}

function Meanings({ legend }: { legend: Legend }) {
  return (
    <ul class="colour-legend">
      {legend.map(([colour, meaning]) => (
        <li key={meaning}>
          <Swatch color={colour} /> {meaning}
        </li>
      ))}
    </ul>
  );
}

const percent = (share: number): string => `${Math.round(share * 100)} %`;
/** The least part of the values that a ramp spans. */
const LEAST = 0.02;

function RampOptions() {
  const { ramp, rampLow, rampHigh } = state.view.value;
  return (
    <>
      <div class="segmented" role="radiogroup" aria-label="Ramp">
        {RAMPS.map(([name, label]) => (
          <button
            key={name}
            type="button"
            role="radio"
            class="button"
            aria-checked={ramp === name}
            onClick={() => actions.setView({ ramp: name })}
          >
            {label}
          </button>
        ))}
      </div>
      <Slider
        label="From"
        value={rampLow}
        min={0}
        max={1}
        tip="Values below have the ramp's first colour"
        shown={percent(rampLow)}
        onInput={(low) => actions.setView({ rampLow: Math.min(low, rampHigh - LEAST) })}
      />
      <Slider
        label="To"
        value={rampHigh}
        min={0}
        max={1}
        tip="Values above have the ramp's last colour"
        shown={percent(rampHigh)}
        onInput={(high) => actions.setView({ rampHigh: Math.max(high, rampLow + LEAST) })}
      />
    </>
  );
}
