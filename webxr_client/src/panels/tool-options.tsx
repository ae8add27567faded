/** The second row: how the tool takes points; beside it, how the recording is shown. */
import { signal } from '@preact/signals';
import { actions } from '../store/actions';
import { findPeople } from '../engine/find-people';
import { floorPlaces } from '../engine/floor';
import {
  activeLabel,
  canEdit,
  isStroke,
  patch,
  RADIUS_MAX,
  RADIUS_MIN,
  sparesLabels,
  state,
} from '../store/state';
import { offers } from '../store/limits';
import { hasDepth } from '../store/sensors';
import { boxDraft } from '../tools/volume';
import { outlineKind, type OutlineKind } from '../tools/lasso';
import { DESK_WAYS, deskWay } from '../tools/ways';
import { Button, Check, Slider } from './parts/controls';
import { CutName } from './parts/cut-name';
import { metres } from '../common/format';
import { PopoverButton } from './parts/popover';
import { RadioGroup, type RadioOption } from './parts/radio-group';
import { ViewOptions } from './stage/view-options';

export function ToolOptions() {
  const tool = state.tool.value;
  return (
    <div class="toolbar-row line options">
      {isStroke(tool) ? <BrushOptions /> : <Hints tool={tool} />}
      <span class="spacer" />
      <ViewOptions />
    </div>
  );
}

function Hints({ tool }: { tool: 'navigate' | 'pick' | 'floor' | 'boxes' }) {
  if (tool === 'floor') return <FloorOptions />;
  if (tool === 'boxes') return <BoxesHint />;
  return tool === 'navigate' ? <NavigateHints /> : <PickHint />;
}

function NavigateHints() {
  return (
    <span class="soft small">
      Drag to turn · right-drag to move · wheel to zoom · <span class="kbd">W A S D</span> to walk
    </span>
  );
}

function BoxesHint() {
  return (
    <span class="soft small">
      Click a labelled object or its box · drag its handles here or at the side ·{' '}
      <span class="kbd">W A S D</span> to move it, <span class="kbd">Q E</span> to turn
    </span>
  );
}

function PickHint() {
  return <span class="soft small">Click a point to choose its label</span>;
}

/** Hints by the number of chosen places on the floor. */
const FLOOR_HINTS = [
  'Click the floor to set it',
  'Set by one place · click a second place far away to level it',
  'Set by two places · click a third place, away from both, to level it',
  'Set by three places · another click replaces the first place',
];

function FloorOptions() {
  return (
    <>
      <span class="soft small" role="status">
        {FLOOR_HINTS[floorPlaces.value]}
      </span>
      <Button
        icon="restore"
        label="Reset to import"
        kind="outlined"
        onClick={() => void actions.view.resetFloor()}
      />
      <Button
        icon="check"
        label="Done"
        kind="outlined"
        onClick={() => actions.tools.setTool('paint')}
      />
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
        options={SHAPES.filter(({ value }) => offers(value))}
        value={brush.shape}
        onChoose={(shape) => actions.tools.setShape(shape)}
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
          onInput={(radius) => actions.tools.setRadius(radius)}
        />
      )}
      {sparesLabels(state.tool.value) && way.name !== 'object' && (
        <Check
          label="Only unlabelled"
          tip="Labelled points keep their label"
          checked={brush.onlyUnlabeled}
          onChange={(onlyUnlabeled) => patch(state.brush, { onlyUnlabeled })}
        />
      )}
      {way.name === 'object' && <ObjectOptions />}
      {state.tool.value === 'paint' && offers('track') && (
        <AfterStroke path={way.samples === 'path'} />
      )}
      {way.through && (
        <Check
          label="Points behind too"
          tip="Paint through the object: also take points behind the first surface"
          checked={brush.through}
          onChange={(through) => patch(state.brush, { through })}
        />
      )}
    </>
  );
}

function ObjectOptions() {
  return (
    <>
      <Check
        label="Overwrite other labels"
        tip="Also label points that have another label"
        checked={state.brush.value.takeLabelled}
        onChange={(takeLabelled) => patch(state.brush, { takeLabelled })}
      />
      {offers('people') && hasDepth.value && (
        <Button
          icon="people"
          label="Find people"
          tip="Find people in this frame by its colours, without a click"
          disabled={!canEdit.value}
          onClick={() => void findPeople()}
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
          <strong>
            <CutName name={label.name} />
          </strong>
        </>
      )}{' '}
      by
    </span>
  );
}

const afterOpen = signal(false);

/** Actions that follow a stroke automatically. */
function AfterStroke({ path }: { path: boolean }) {
  const brush = state.brush.value;
  return (
    <PopoverButton
      open={afterOpen}
      icon="more"
      tip="After a stroke: complete the object, track the label"
      label="After a stroke"
      class="stack"
    >
      {path && (
        <Check
          label="Offer objects"
          tip="Offer to complete a stroke to the object under it"
          checked={brush.complete}
          onChange={(complete) => patch(state.brush, { complete })}
        />
      )}
      <Check
        label="Follow"
        tip="Track painted labels automatically, to the next painted frame or the end"
        checked={brush.follow}
        onChange={(follow) => patch(state.brush, { follow })}
      />
    </PopoverButton>
  );
}

/** Kinds of lasso. */
const KINDS: readonly RadioOption<OutlineKind>[] = [
  { value: 'free', icon: 'lasso', label: 'Free', tip: 'Draw the outline with the button held', keys: 'O' },
  { value: 'rectangle', icon: 'rectangle', label: 'Rectangle', tip: 'Drag from corner to corner', keys: 'O' },
  { value: 'polygon', icon: 'polygon', label: 'Polygon', tip: 'Click the corners; Enter, a double click or a click on the first corner closes the polygon, Backspace removes a corner', keys: 'O' },
]; // prettier-ignore

function OutlineKinds() {
  return (
    <RadioGroup
      label="Outline"
      class="segmented outlines"
      options={KINDS}
      value={outlineKind.value}
      onChoose={(kind) => (outlineKind.value = kind)}
    />
  );
}

/** Actions of the box tool, in the tool bar. */
function BoxOptions() {
  if (!boxDraft.value) return <span class="soft small">Drag over the floor</span>;
  return (
    <>
      <Button
        icon="plane"
        label="Snap to ground"
        kind="outlined"
        tip="Move the bottom of the box to just above the ground"
        keys="Shift G"
        onClick={() => actions.tools.snapBox()}
      />
      <Button
        icon="check"
        label="Take"
        kind="primary"
        tip="Apply the tool to the points in the box"
        keys="Enter"
        onClick={() => actions.tools.closeOutline()}
      />
    </>
  );
}
