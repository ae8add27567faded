/** Options of the view: colours and their ramp, sizes, and overlays. */
import { signal } from '@preact/signals';
import { actions } from '../../store/actions';
import { colorModeOf } from '../../cloud/picture/material';
import { BETWEEN, PAINTED, SURE, TRACKED, UNKNOWN, UNSURE } from '../../engine/labels/colouring';
import { type ColorMode, type Ramp, state } from '../../store/state';
import { colourFields, hasDepth } from '../../store/sensors';
import type { SurfaceMode } from '../../store/types';
import { AccumulateButton } from './accumulate';
import { CamerasButton } from './cameras';
import { ClipButton } from './clip';
import { SensorsButton } from './sensors';
import { Check, Slider, Swatch } from '../parts/controls';
import { percent } from '../../common/format';
import { Icon } from '../../common/icons';
import { Choice } from '../parts/fields';
import { PopoverButton } from '../parts/popover';
import { RadioGroup, type RadioOption } from '../parts/radio-group';

const COLOR_MODES: readonly (readonly [mode: ColorMode, words: string, field?: string])[] = [
  ['rgb', 'Colour', 'rgb'],
  ['intensity', 'Intensity', 'intensity'],
  ['height', 'Height'],
  ['distance', 'Distance'],
  ['normal', 'Normal'],
  ['plain', 'Plain'],
  ['label', 'Label'],
  ['confidence', 'Confidence'],
  ['provenance', 'Painted or tracked'],
  ['sensor', 'Sensor', 'sensor'],
];

export function ViewOptions() {
  const view = state.view.value;
  const fields = colourFields.value;
  return (
    <>
      <Choice
        label="Colour points by"
        tip="Colour points by"
        value={colorModeOf(view.color, fields)}
        choices={COLOR_MODES.filter(([, , field]) => !field || fields.includes(field))}
        onChange={(color) => actions.view.setView({ color })}
      />
      <RampButton />
      <ViewSliders class="of-view" />
      <CamerasButton />
      <ClipButton />
      <SensorsButton />
      <AccumulateButton />
      <OverlayOptions />
    </>
  );
}

/** Sliders of the look of points, in the bar where there is room, in the menu of layers always. */
function ViewSliders({ class: extra }: { class?: string }) {
  const view = state.view.value;
  return (
    <>
      <Slider
        label="Labels over colour"
        {...(extra && { class: extra })}
        before={<Icon name="view" />}
        value={view.labelBlend}
        min={0}
        max={1}
        tip="Blend from source colours to label colours"
        shown={`${Math.round(view.labelBlend * 100)} %`}
        onInput={(labelBlend) => actions.view.setView({ labelBlend })}
      />
      <Slider
        label="Point size"
        {...(extra && { class: extra })}
        before={<Icon name="points" />}
        value={view.pointSize}
        min={0.25}
        max={4}
        logarithmic
        tip="Point size"
        shown={`${view.pointSize.toFixed(1)}×`}
        onInput={(pointSize) => actions.view.setView({ pointSize })}
      />
    </>
  );
}

const SURFACES: readonly RadioOption<SurfaceMode>[] = [
  { value: 'points', label: 'Points' },
  { value: 'surface', label: 'Surface' },
  { value: 'auto', label: 'Auto', tip: 'Surface near enough to see gaps between points' },
];

/** Look of a depth camera's frames. */
function SurfaceOptions() {
  if (!hasDepth.value) return null;
  return (
    <RadioGroup
      label="Depth images"
      options={SURFACES}
      value={state.view.value.surface}
      onChoose={(surface) => actions.view.setView({ surface })}
    />
  );
}

const overlaysOpen = signal(false);

/** Overlays: setting, name and purpose. */
export const OVERLAYS: readonly (readonly [
  'boxes' | 'trails' | 'ghost' | 'eyeDome' | 'showDeleted',
  string,
  string,
])[] = [
  ['boxes', 'Boxes', 'A box around each labelled object'],
  ['trails', 'Trails', 'Paths of the objects through neighbouring frames'],
  ['ghost', 'Ghost of the previous frame', 'Faint objects at their places in the previous frame'],
  ['eyeDome', 'Depth shading', 'Darken depth edges to emphasise shapes'],
  [
    'showDeleted',
    'Deleted points',
    'Show deleted points in dark red; the Restore tool always shows them',
  ],
];

function OverlayOptions() {
  const view = state.view.value;
  return (
    <PopoverButton
      open={overlaysOpen}
      icon="layers"
      tip="Overlays: boxes, trails, shading"
      button={{ label: 'Overlays' }}
      label="Overlays"
      class="stack"
    >
      <SurfaceOptions />
      <ViewSliders />
      {OVERLAYS.map(([name, label, tip]) => (
        <Check
          key={name}
          label={label}
          tip={tip}
          checked={view[name]}
          onChange={(on) => actions.view.setView({ [name]: on })}
        />
      ))}
    </PopoverButton>
  );
}

/** Legend and range of a colour ramp: the part of the values that it spans, and their colours. */
const rampOpen = signal(false);

const RAMPS: readonly RadioOption<Ramp>[] = [
  { value: 'even', label: 'Even' },
  { value: 'grey', label: 'Grey' },
  { value: 'rainbow', label: 'Rainbow' },
];

type Legend = readonly (readonly [colour: string, meaning: string])[];

const LEGENDS: Partial<Record<ColorMode, Legend>> = {
  normal: [
    ['#80ff80', 'faces up'],
    ['#800080', 'faces down'],
    ['#ff8080', 'faces right, from the front'],
    ['#008080', 'faces left'],
    ['#8080ff', 'faces the front'],
    ['#808000', 'faces the back'],
  ],
  confidence: [
    [SURE, 'certain, or painted'],
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

function RampButton() {
  const { color } = state.view.value;
  const legend = LEGENDS[color];
  if (!legend && !RAMPED.includes(color)) return null;
  return (
    <PopoverButton
      open={rampOpen}
      icon="more"
      tip={legend ? 'Legend of the colours' : 'Colour ramp and range'}
      label="Colours"
      class="stack"
    >
      {legend ? <Meanings legend={legend} /> : <RampOptions />}
    </PopoverButton>
  );
}

function Meanings({ legend }: { legend: Legend }) {
  return (
    <ul class="stack">
      {legend.map(([colour, meaning]) => (
        <li key={meaning} class="line">
          <Swatch color={colour} /> {meaning}
        </li>
      ))}
    </ul>
  );
}

/** The least part of the values that a ramp spans. */
const LEAST = 0.02;

function RampOptions() {
  const { ramp, rampLow, rampHigh } = state.view.value;
  return (
    <>
      <RadioGroup
        label="Ramp"
        options={RAMPS}
        value={ramp}
        onChoose={(name) => actions.view.setView({ ramp: name })}
      />
      <Slider
        label="From"
        value={rampLow}
        min={0}
        max={1}
        tip="Values below have the ramp's first colour"
        shown={percent(rampLow)}
        onInput={(low) => actions.view.setView({ rampLow: Math.min(low, rampHigh - LEAST) })}
      />
      <Slider
        label="To"
        value={rampHigh}
        min={0}
        max={1}
        tip="Values above have the ramp's last colour"
        shown={percent(rampHigh)}
        onInput={(high) => actions.view.setView({ rampHigh: Math.max(high, rampLow + LEAST) })}
      />
    </>
  );
}
