/** The second row: how the tool takes points, and how the recording is shown. */
import { signal } from '@preact/signals';
import { useRef } from 'preact/hooks';
import { actions } from '../actions';
import { colorModeOf } from '../cloud/material';
import { floorPlaces } from '../engine/floor';
import { activeLabel, isStroke, patch, sparesLabels, RADIUS_MAX, RADIUS_MIN, state, type ColorMode } from '../state'; // prettier-ignore
import { DESK_WAYS, deskWay } from '../tools/ways';
import { OutlineKinds } from './outline-kinds';
import { AccumulateButton } from './accumulate';
import { BoxOptions } from './box-options';
import { ClipButton } from './clip';
import { CamerasButton } from './cameras';
import { RampButton } from './ramp';
import { Button, Check, Slider } from './controls';
import { metres } from './format';
import { Icon } from './icon';
import { Popover } from './popover';
import { RadioGroup } from './radio-group';

const COLOR_MODES: readonly (readonly [ColorMode, string, string])[] = [
  ['rgb', 'Colour', 'rgb'],
  ['intensity', 'Intensity', 'intensity'],
  ['height', 'Height', ''],
  ['distance', 'Distance', ''],
  ['plain', 'Plain', ''],
  ['label', 'Label', ''],
  ['confidence', 'Confidence', ''],
  ['provenance', 'Provenance', ''],
];

export function ToolOptions() {
  const tool = state.tool.value;
  return (
    <div class="toolbar-row options">
      {isStroke(tool) ? <BrushOptions /> : <Hints tool={tool} />}
      <span class="spacer" />
      <ViewOptions />
    </div>
  );
}

function Hints({ tool }: { tool: 'navigate' | 'pick' | 'floor' }) {
  if (tool === 'floor') return <FloorOptions />;
  return tool === 'navigate' ? <NavigateHints /> : <PickHint />;
}

function NavigateHints() {
  return (
    <span class="hint">
      Drag to turn · right-drag to move · wheel to come closer · <span class="kbd">W A S D</span> to
      walk
    </span>
  );
}

function PickHint() {
  return <span class="hint">Click a point to continue with its label</span>;
}

/** Places on the floor, and what to do next. */
const FLOOR_HINTS = [
  'Click the floor: the recording will stand on it',
  'Stands on one place · another one, far from it, levels it better',
  'Stands on two places · a third one, apart from both, levels it better',
  'Stands on three places · a further one takes the place of the first',
];

function FloorOptions() {
  return (
    <>
      <span class="hint" role="status">
        {FLOOR_HINTS[floorPlaces.value]}
      </span>
      <Button
        icon="restore"
        label="As found at import"
        kind="outlined"
        onClick={() => void actions.resetFloor()}
      />
      <Button icon="check" label="Done" kind="outlined" onClick={() => actions.setTool('paint')} />
    </>
  );
}

const SHAPES = DESK_WAYS.map(({ shape, icon, desk }) => ({
  value: shape,
  icon,
  label: desk.label,
  tip: desk.tip,
  keys: desk.key,
}));

function BrushOptions() {
  const brush = state.brush.value;
  const way = deskWay(brush.shape);
  return (
    <>
      <Action />
      <RadioGroup
        label="Shape"
        class="segmented"
        options={SHAPES}
        value={brush.shape}
        onChoose={(shape) => actions.setShape(shape)}
      />
      {way.name === 'lasso' && <OutlineKinds />}
      {way.name === 'box' && <BoxOptions />}
      {way.size !== null && (
        <Slider
          label={way.size}
          value={brush.radius}
          min={RADIUS_MIN}
          max={RADIUS_MAX}
          logarithmic
          tip="Size of the brush"
          keys="[ ]"
          shown={metres(brush.radius)}
          onInput={(radius) => actions.setRadius(radius)}
        />
      )}
      {sparesLabels(state.tool.value) && way.name !== 'object' && (
        <Check
          label="Only unlabeled"
          tip="Points that have a label keep it"
          checked={brush.onlyUnlabeled}
          onChange={(onlyUnlabeled) => patch(state.brush, { onlyUnlabeled })}
        />
      )}
      {way.name === 'object' && (
        <Check
          label="Take from other labels"
          tip="Points that have another label are taken as well"
          checked={brush.takeLabelled}
          onChange={(takeLabelled) => patch(state.brush, { takeLabelled })}
        />
      )}
      {state.tool.value === 'paint' && <AfterStroke path={way.samples === 'path'} />}
      {way.through && (
        <Check
          label="Through"
          tip="Also points behind the first surface"
          checked={brush.through}
          onChange={(through) => patch(state.brush, { through })}
        />
      )}
    </>
  );
}

const ACTIONS = {
  paint: 'Paint',
  erase: 'Erase labels',
  delete: 'Delete points',
  restore: 'Restore points',
} as const;

/** The beginning of the sentence that the chosen shape ends: "Paint person by object". */
function Action() {
  const tool = state.tool.value;
  const label = activeLabel.value;
  if (!isStroke(tool)) return null;
  return (
    <span class="action">
      {ACTIONS[tool]}
      {tool === 'paint' && label && (
        <>
          <span class="swatch" style={{ '--color': label.color }} />
          <strong>{label.name}</strong>
        </>
      )}{' '}
      by
    </span>
  );
}

const afterOpen = signal(false);

/** Actions that follow a stroke by themselves. */
function AfterStroke({ path }: { path: boolean }) {
  const anchor = useRef<HTMLButtonElement>(null);
  const brush = state.brush.value;
  return (
    <>
      <Button
        buttonRef={anchor}
        icon="more"
        tip="After a stroke: offer its object, track it on"
        expanded={afterOpen.value}
        onClick={() => (afterOpen.value = !afterOpen.value)}
      />
      {afterOpen.value && (
        <Popover
          anchor={anchor}
          label="After a stroke"
          onClose={() => (afterOpen.value = false)}
          class="overlays"
        >
          {path && (
            <Check
              label="Offer objects"
              tip="Offer to complete a stroke to the object that it lies on"
              checked={brush.complete}
              onChange={(complete) => patch(state.brush, { complete })}
            />
          )}
          <Check
            label="Follow"
            tip="Track what you paint on by itself, to the next painted frame or the end"
            checked={brush.follow}
            onChange={(follow) => patch(state.brush, { follow })}
          />
        </Popover>
      )}
    </>
  );
}

const overlaysOpen = signal(false);

/** Overlays: the setting, its name, what it is for. */
const OVERLAYS: readonly (readonly [
  'boxes' | 'trails' | 'ghost' | 'eyeDome' | 'showDeleted',
  string,
  string,
])[] = [
  ['boxes', 'Boxes', 'A box round each labelled object'],
  ['trails', 'Trails', 'The ways of the objects through the frames near this one'],
  ['ghost', 'Ghost of the frame before', 'Where the objects were a frame before, faintly'],
  ['eyeDome', 'Depth shading', 'Darken edges in depth, so that shapes stand out'],
  ['showDeleted', 'Deleted points', 'Points deleted as noise, dark red; Restore shows them anyway'],
];

function OverlayOptions() {
  const anchor = useRef<HTMLButtonElement>(null);
  const view = state.view.value;
  return (
    <>
      <Button
        buttonRef={anchor}
        icon="layers"
        tip="Drawn over the recording: boxes, trails, shading"
        expanded={overlaysOpen.value}
        onClick={() => (overlaysOpen.value = !overlaysOpen.value)}
      />
      {overlaysOpen.value && (
        <Popover
          anchor={anchor}
          label="Drawn over the recording"
          onClose={() => (overlaysOpen.value = false)}
          class="overlays"
        >
          {OVERLAYS.map(([name, label, tip]) => (
            <Check
              key={name}
              label={label}
              tip={tip}
              checked={view[name]}
              onChange={(on) => actions.setView({ [name]: on })}
            />
          ))}
        </Popover>
      )}
    </>
  );
}

function ViewOptions() {
  const view = state.view.value;
  const fields = state.sequence.value?.fields ?? [];
  return (
    <>
      <select
        class="field"
        aria-label="Colour points by"
        data-tip="Colour points by"
        value={colorModeOf(view.color, fields)}
        onChange={(event) => actions.setView({ color: event.currentTarget.value as ColorMode })}
      >
        {COLOR_MODES.filter(([, , field]) => !field || fields.includes(field)).map(
          ([mode, name]) => (
            <option key={mode} value={mode}>
              {name}
            </option>
          ),
        )}
      </select>
      <RampButton />
      <Slider
        label="Labels over colour"
        before={<Icon name="view" />}
        value={view.labelBlend}
        min={0}
        max={1}
        tip="From the recording's own colours to label colours only"
        shown={`${Math.round(view.labelBlend * 100)} %`}
        onInput={(labelBlend) => actions.setView({ labelBlend })}
      />
      <Slider
        label="Point size"
        before={<Icon name="points" />}
        value={view.pointSize}
        min={0.25}
        max={4}
        logarithmic
        tip="Point size"
        shown={`${view.pointSize.toFixed(1)}×`}
        onInput={(pointSize) => actions.setView({ pointSize })}
      />
      <CamerasButton />
      <ClipButton />
      <AccumulateButton />
      <OverlayOptions />
    </>
  );
}
