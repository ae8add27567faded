/** Overlay of the canvas: states, progress, and the point under the pointer. */
import type { ComponentChild } from 'preact';
import { useEffect, useState } from 'preact/hooks';
import { actions } from '../../store/actions';
import { DELETED } from '../../cloud/points/piece';
import { orthographic } from '../../view/framing';
import type { Unsent } from '../../net/wire';
import { activeLabel, isStroke, state, type Hover } from '../../store/state';
import { AccumulateSign } from './accumulate';
import { CameraPanel } from './cameras';
import { ClipSign } from './clip';
import { SensorsSign } from './sensors';
import { Button, Swatch } from '../parts/controls';
import { listOpen } from '../../store/palette-list';
import { plural, metres, shortCount } from '../../common/format';
import { dropping } from '../importing/files';
import { Icon } from '../../common/icons';
import { JobCards } from './jobs';
import { ObjectBar } from './object-bar';
import { PeopleBar } from './people-bar';
import { Toasts } from './toasts';
import { Views } from './views';
import { Welcome } from '../importing/welcome';

export function Stage({ bars }: { bars: readonly (() => ComponentChild)[] }) {
  const { session } = state.xr.value;
  if (session === 'running') return <InHeadset />;
  return (
    <>
      {state.sequence.value ? <InRecording /> : <Welcome />}
      <div class="bottom">
        <JobCards />
        <Toasts />
        {state.sequence.value && <ObjectBar />}
        <PeopleBar />
        {bars.map((More) => (
          <More />
        ))}
      </div>
      {dropping.value && <DropTarget />}
    </>
  );
}

function InRecording() {
  return (
    <>
      <OfflineBanner />
      <Missing />
      <div class="signs small">
        <AccumulateSign />
        <ClipSign />
        <SensorsSign />
      </div>
      <CameraPanel />
      <Readout />
      <Views />
    </>
  );
}

/** The reason for which the stage shows no points, in its middle. */
function Missing() {
  const { frame, total } = state.shown.value;
  if (state.pictureLost.value) return <PictureLost />;
  if (frame < 0 || state.opening.value !== null) return <Opening />;
  return total === 0 ? <EmptyFrame /> : null;
}

function Opening() {
  return (
    <div class="center" role="status">
      <div class="spinner" />
      <p class="soft">Opening {state.sequence.value?.name ?? 'the recording'}…</p>
    </div>
  );
}

/** Until the browser restores the graphics context, which it may never do. */
function PictureLost() {
  return (
    <div class="center message" role="alert">
      <Icon name="warning" />
      <p>
        The graphics card stopped drawing. The picture returns when the browser restores it; all
        labels are kept.
      </p>
      <Button label="Reload the page" kind="outlined" onClick={() => location.reload()} />
    </div>
  );
}

function EmptyFrame() {
  return (
    <div class="center" role="status">
      <p class="soft">This frame has no points to paint</p>
    </div>
  );
}

function OfflineBanner() {
  const { state: connection, detail, retryAt, unsent } = state.connection.value;
  const pending = state.pending.value;
  if (connection === 'online') return null;
  if (connection === 'refused') {
    return (
      <div class="banner card line bad" role="alert">
        <Icon name="warning" />
        <span>
          <strong>The server refused this page.</strong> {detail} {unsentText(unsent)}
        </span>
      </div>
    );
  }
  return (
    <div class="banner card line" role="status">
      <Icon name="offline" />
      <span>
        <strong>The server does not answer.</strong> You can continue to paint
        {pending > 0 ? `; ${plural(pending, 'stroke')} will be sent when it answers.` : '.'}
      </span>
      <Retry at={retryAt} />
    </div>
  );
}

const MOST_NAMED = 4;

/** Strokes that the server did not take, by name. */
function unsentText(unsent: readonly Unsent[]): string {
  if (unsent.length === 0) return '';
  const strokes = unsent.slice(0, MOST_NAMED).map(({ frame, tool, label }) => {
    const name = label ? state.palette.value.find(({ id }) => id === label)?.name : undefined;
    return `${name ?? tool} in frame ${frame}`;
  });
  const more = unsent.length > MOST_NAMED ? `, and ${unsent.length - MOST_NAMED} more` : '';
  return (
    `${plural(unsent.length, 'stroke')} not sent: ${strokes.join(', ')}${more}. ` +
    'This browser keeps them and sends them when you open the recording with a valid link.'
  );
}

function Retry({ at }: { at: number | null }) {
  const [now, setNow] = useState(() => performance.now());
  useEffect(() => {
    const timer = setInterval(() => setNow(performance.now()), 1000);
    return () => clearInterval(timer);
  }, []);
  const seconds = at === null ? 0 : Math.ceil((at - now) / 1000);
  return (
    <>
      {seconds > 0 && <span class="number soft">Next attempt in {seconds} s</span>}
      <Button label="Try now" kind="outlined" onClick={() => actions.page.reconnect()} />
    </>
  );
}

/** Bottom left: the point under the pointer, and whether the frame is complete. */
function Readout() {
  const hover = state.hover.value;
  const { points, total } = state.shown.value;
  return (
    <div class="readout number small">
      <LabelsButton />
      {hover && <Hovered hover={hover} />}
      {points < total && (
        <span class="soft">
          {shortCount(points)} of {shortCount(total)} points
        </span>
      )}
      {state.tool.value === 'paint' && !activeLabel.value && total > 0 && (
        <span>Choose or create a label to paint</span>
      )}
    </div>
  );
}

/** In a small window: opens the labels. */
function LabelsButton() {
  const label = activeLabel.value;
  return (
    <button
      type="button"
      class="button sheet-part"
      aria-label={label ? `Labels: ${label.name}` : 'Labels'}
      aria-expanded={listOpen.value}
      onClick={() => (listOpen.value = !listOpen.value)}
    >
      {label && <Swatch color={label.color} />}
      <span class="name">{label?.name ?? 'Labels'}</span>
    </button>
  );
}

function Hovered({ hover }: { hover: Hover }) {
  const label = state.palette.value.find((entry) => entry.id === hover.label);
  const brush = isStroke(state.tool.value) && hover.points > 0;
  return (
    <span>
      {label && <Swatch color={label.color} />}
      {label?.name ?? (hover.label === DELETED ? 'Deleted' : 'Unlabelled')}
      <span class="soft">
        {!orthographic.value && metres(hover.distance)}
        {brush ? ` · ${plural(hover.points, 'point')} in the brush` : ''}
      </span>
    </span>
  );
}

function DropTarget() {
  return (
    <div class="drop-target title">
      <Icon name="import" />
      <p>Drop to import as one recording</p>
    </div>
  );
}

function InHeadset() {
  return (
    <div class="center in-headset" role="status">
      <Icon name="headset" />
      <p>The recording is in the headset.</p>
      <Button label="Leave VR" kind="outlined" onClick={() => void actions.page.exitVR()} />
    </div>
  );
}
