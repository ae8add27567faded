/** The boxes at the side: fitting, three views of the chosen one, copies, attributes. */
import type { BoxFit } from '../protocol/values';
import { signal } from '@preact/signals';
import { percent, plural } from '../common/format';
import { Button, Swatch } from '../panels/parts/controls';
import { MenuItem, PopoverButton } from '../panels/parts/popover';
import { actions } from '../store/actions';
import { boxes, chosenBox, type BoxPose, type ObjectBox } from '../store/boxes';
import { activeLabel, canEdit, state, trackingJob } from '../store/state';
import { BoxAttributes } from './attributes';
import {
  boxFromPoints,
  copyToShownFrame,
  changeBox,
  copyToFrame,
  fitBoxes,
  interpolate,
  patchSize,
  pointsFromBox,
  removeBox,
  trackAndFit,
  turnRound,
} from './changes';
import { drawing } from './new';
import { BoxViews } from './views';

export function BoxesPanel() {
  if (state.tool.value !== 'boxes' || !state.sequence.value) return null;
  if (state.xr.value.session === 'running') return null;
  const box = chosenBox.value;
  return (
    <>
      <Head box={box} />
      {box ? <Chosen box={box} /> : <Without />}
    </>
  );
}

function Head({ box }: { box: ObjectBox | null }) {
  const label = activeLabel.value;
  const pose = box?.poses[state.shown.value.frame];
  return (
    <header class="panel-head line">
      {label && <Swatch color={label.color} />}
      <h2 class="name">{label?.name ?? 'Boxes'}</h2>
      {pose && <Origin pose={pose} />}
      {box?.heading_known === false && <span class="pill" data-tip="The points do not show which end is the front. “Turn round” sets it, and so does “Front known”">Front unknown</span>}
      <span class="spacer" />
      {box && <More box={box} />}
      <Button icon="close" tip="Close the boxes panel" small onClick={() => actions.tools.setTool('navigate')} />
    </header>
  ); // prettier-ignore
}

const ORIGINS = { fitted: 'Fitted', drawn: 'Drawn', imported: 'Imported' } as const;

/** Origin of the pose in this frame, and how sure it is. */
function Origin({ pose: { provenance, confidence } }: { pose: BoxPose }) {
  const sure = provenance === 'fitted';
  return (
    <span class={`box-origin pill ${provenance}`} data-tip={sure ? 'Fitted to the points; dashed in the cloud. Dragging it makes it a drawn box' : 'Fitting does not change it'}>
      {ORIGINS[provenance]}
      {sure && <span class="number"> {percent(confidence)}</span>}
    </span>
  ); // prettier-ignore
}

const moreOpen = signal(false);

function More({ box }: { box: ObjectBox }) {
  const { frame } = state.shown.value;
  return (
    <PopoverButton open={moreOpen} icon="more" small tip="More about this box" label="This box" class="menu">
      <MenuItem label="Label the points in the box in all frames" disabled={!canEdit.value} onClick={() => void pointsFromBox(true)} />
      <MenuItem label="Remove from this frame" disabled={!canEdit.value || !(frame in box.poses)} onClick={() => void changeBox(box.id, { poses: { [frame]: null } })}>
        <span class="end kbd">Delete</span>
      </MenuItem>
      <MenuItem label="Delete the box" disabled={!canEdit.value} onClick={() => void removeBox(box)}>
        <span class="end kbd">Shift Delete</span>
      </MenuItem>
    </PopoverButton>
  ); // prettier-ignore
}

/** No box is chosen: how one gets there. */
function Without() {
  const label = activeLabel.value;
  const labelled = label !== null && (state.counts.value.get(label.id) ?? 0) > 0;
  return (
    <div class="box-without stack">
      <p>{!label ? 'Click a labelled object, or choose a label.' : labelled ? 'No box yet. Fit one to the label’s points in all frames.' : 'No box yet. Draw one, or label the object first.'}</p>
      {labelled && <FitButton kind="primary" />}
      {labelled && <TrackFit />}
      <DrawButton />
      <p class="soft">{plural(boxes.value.size, 'box').replace('boxs', 'boxes')} in this recording</p>
    </div>
  ); // prettier-ignore
}

function TrackFit() {
  return (
    <Button icon="track" label="Track and fit" kind="outlined" tip="Track the label through all frames, then fit its box" disabled={!canEdit.value || trackingJob.value !== null} onClick={trackAndFit} />
  ); // prettier-ignore
}

function DrawButton() {
  return (
    <Button icon="box" label={drawing.value ? 'Click, or drag over the floor…' : 'Draw a box'} kind="outlined" tip="Click the object, or drag a rectangle over the floor under it" pressed={drawing.value} disabled={!canEdit.value} onClick={() => (drawing.value = !drawing.value)} />
  ); // prettier-ignore
}

const fitOpen = signal(false);

/** Buttons that fit the box of this label, of all labels of its class, and of all labels. */
function FitButton({ kind = 'outlined' }: { kind?: 'primary' | 'outlined' }) {
  const label = activeLabel.value;
  const start = (fit: Partial<BoxFit>) => (): void => {
    void fitBoxes({ labels: null, category: null, frames: null, ...fit });
  };
  const own = label ? start({ labels: [label.id] }) : start({});
  return (
    <div class="group">
      <Button icon="target" label="Fit" kind={kind} tip="Fit the box to the label’s points in all frames; drawn boxes stay" disabled={!canEdit.value} onClick={own} />
      <PopoverButton open={fitOpen} icon="chevron" tip="Fit more boxes" kind={kind} disabled={!canEdit.value} label="Fit boxes" class="menu">
        {label && <MenuItem label={`Fit ${label.name}`} onClick={own} />}
        {label?.category && <MenuItem label={`Fit every ${label.category}`} onClick={start({ category: label.category })} />}
        <MenuItem label="Fit all labels" onClick={start({})} />
      </PopoverButton>
    </div>
  ); // prettier-ignore
}

function Chosen({ box }: { box: ObjectBox }) {
  const isInFrame = state.shown.value.frame in box.poses;
  const no = !canEdit.value;
  return (
    <>
      {isInFrame ? <BoxViews /> : <MissingInFrame box={box} />}
      <div class="box-actions line wrap">
        <FitButton />
        <Button label="Copy to next" icon="next" kind="outlined" keys="Shift C" tip="Copy the box to the next frame, along the track or on the ground" disabled={no || !isInFrame} onClick={() => void copyToFrame(1)} />
        <Button label="Interpolate" kind="outlined" keys="Shift L" tip="Fill the frames between two drawn boxes" disabled={no} onClick={() => void interpolate()} />
        <Button label="Turn round" kind="outlined" keys="Shift T" tip="Turn the box by 180° in all frames; its front then counts as known" disabled={no} onClick={() => void turnRound()} />
        <Button label="Box from points" kind="outlined" keys="Shift F" tip="Fit this frame’s box to the label’s points" disabled={no} onClick={() => void boxFromPoints()} />
        <Button label="Points from box" kind="outlined" keys="Shift P" tip="Label the points inside the box in this frame" disabled={no || !isInFrame} onClick={() => void pointsFromBox(false)} />
        <DrawButton />
      </div>
      <div class="box-more stack">
        <Sizes box={box} />
        <BoxAttributes box={box} />
      </div>
    </>
  ); // prettier-ignore
}

function MissingInFrame({ box }: { box: ObjectBox }) {
  const frames = Object.keys(box.poses).length;
  return (
    <div class="box-without stack">
      <p>Not in this frame. It is in {plural(frames, 'frame')}.</p>
      <Button label="Copy to this frame" kind="primary" tip="Copy the box from the nearest frame" disabled={!canEdit.value} onClick={() => void copyToShownFrame()} />
    </div>
  ); // prettier-ignore
}

const EDGES = ['Length', 'Width', 'Height'] as const;

function Sizes({ box }: { box: ObjectBox }) {
  return (
    <fieldset class="box-sizes" disabled={!canEdit.value}>
      {EDGES.map((name, axis) => (
        <label key={name} class="row" data-tip="Size of the object in metres, the same in all frames">
          <span>{name}</span>
          <input class="field number" type="number" min={0.05} step={0.01} value={box.size[axis]!.toFixed(2)} onChange={(event) => patchSize(box, axis as 0 | 1 | 2, Number(event.currentTarget.value))} />
        </label>
      ))}
    </fieldset>
  ); // prettier-ignore
}
