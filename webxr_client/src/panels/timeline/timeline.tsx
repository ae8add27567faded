/** Time, below: transport, ruler, and one strip per label; its height, which is kept and can be dragged. */
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { actions } from '../../store/actions';
import { state } from '../../store/state';
import { follow } from '../../store/watch';
import { followPointer } from '../parts/drag';
import { Choice } from '../parts/fields';
import { Button } from '../parts/controls';
import { Doubt } from './doubt';
import { clock, plural } from '../../common/format';
import { keep, kept } from '../../store/kept';
import { frameRange, ordered } from '../../store/range';
import { StripLegend } from './legend';
import { StripCard, StripMenu } from './strip-pointer';
import { doubtfulFrames } from '../../store/cells';
import { Strips } from './strips';
import { trackOpen } from './track-form';

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];

export function Timeline() {
  const sequence = state.sequence.value;
  if (!sequence) return null;
  return (
    <>
      <TimelineHandle />
      <div class="transport line">
        <Transport />
        <span class="divider" />
        <Position frames={sequence.frames} fps={sequence.fps} />
        <span class="spacer" />
        <Doubt />
        <RangeChip />
        <Doubtful frames={sequence.frames} />
        <StripLegend />
      </div>
      <Strips frames={sequence.frames} />
      <StripCard />
      <StripMenu />
    </>
  );
}

function Transport() {
  const playing = state.playing.value;
  const speed = state.speed.value;
  const speeds = SPEEDS.includes(speed) ? SPEEDS : [...SPEEDS, speed].sort((a, b) => a - b);
  return (
    <div class="group">
      <Button icon="first" tip="First frame" keys="Home" onClick={() => actions.time.seek(0)} />
      <Button icon="back" tip="One frame back" keys="←" onClick={() => actions.time.step(-1)} />
      <Button
        icon={playing ? 'pause' : 'play'}
        tip={playing ? 'Pause' : 'Play'}
        keys="Space"
        class="play"
        onClick={() => actions.time.togglePlay()}
      />
      <Button
        icon="forward"
        tip="One frame forward"
        keys="→"
        onClick={() => actions.time.step(1)}
      />
      <Button
        icon="last"
        tip="Last frame"
        keys="End"
        onClick={() => actions.time.seek((state.sequence.peek()?.frames ?? 1) - 1)}
      />
      <Button
        icon="loop"
        tip="Loop"
        keys="L"
        pressed={state.loop.value}
        onClick={() => actions.time.toggleLoop()}
      />
      <Choice
        class="speed"
        label="Speed"
        tip="Speed"
        value={String(speed)}
        choices={speeds.map((value) => [String(value), `${value}×`] as const)}
        onChange={(value) => actions.time.setSpeed(Number(value))}
      />
    </div>
  );
}

function Position({ frames, fps }: { frames: number; fps: number }) {
  const frame = state.frame.value;
  return (
    <span class="position line baseline number">
      <b class="title">{frame}</b>
      <span class="faint">/ {frames - 1}</span>
      {fps > 0 && <span class="soft">{clock(frame / fps)}</span>}
    </span>
  );
}

function RangeChip() {
  const range = frameRange.value;
  if (!range) return null;
  const [from, to] = ordered(range);
  return (
    <span class="pill number">
      Frames {from} – {to}
      <Button label="Track…" kind="outlined" small onClick={() => (trackOpen.value = true)} />
      <Button icon="close" tip="Clear the range" small onClick={() => (frameRange.value = null)} />
    </span>
  );
}

function Doubtful({ frames }: { frames: number }) {
  const doubtful = doubtfulFrames(state.timeline.value.rows.values(), frames);
  if (doubtful.length === 0) return null;
  return (
    <span class="pill warn number">
      <Button
        icon="previous"
        tip="Previous doubtful frame"
        keys=","
        small
        onClick={() => actions.time.nextDoubtful(-1)}
      />
      {plural(doubtful.length, 'doubtful frame')}
      <Button
        icon="next"
        tip="Next doubtful frame"
        keys="."
        small
        onClick={() => actions.time.nextDoubtful(1)}
      />
    </span>
  );
}

/** Pixels: transport, ruler and four strips, two in a low window; and with one, which is the least. */
const TIMELINE_DEFAULT = innerHeight < 560 ? 110 : 146;
const TIMELINE_LEAST = 92;
/** Part of the window that the picture keeps. */
const LEAST_PICTURE = 0.5;
const STEP = 18;
const KEY = 'pointbrush.timeline-height';

function clampHeight(height: number): number {
  const above = document.getElementById('toolbar')!.offsetHeight;
  const most = Math.max(TIMELINE_LEAST, (1 - LEAST_PICTURE) * innerHeight - above);
  return Math.round(Math.min(most, Math.max(TIMELINE_LEAST, height)));
}

const height = signal(TIMELINE_DEFAULT);

function setHeight(wanted: number): void {
  height.value = clampHeight(wanted);
  keep(KEY, String(height.peek()));
}

/** The edge between picture and timeline. */
function TimelineHandle() {
  useEffect(() => {
    height.value = clampHeight(Number(kept(KEY)) || TIMELINE_DEFAULT);
    return follow(() => {
      document.getElementById('timeline')!.style.height = `${height.value}px`;
    });
  }, []);
  return (
    <div
      class="timeline-handle"
      role="separator"
      tabIndex={0}
      aria-label="Height of the timeline"
      aria-orientation="horizontal"
      aria-valuemin={TIMELINE_LEAST}
      aria-valuenow={height.value}
      data-tip="Drag to change the height of the timeline"
      onPointerDown={drag}
      onDblClick={() => setHeight(TIMELINE_DEFAULT)}
      onKeyDown={(event) => {
        const step = event.key === 'ArrowUp' ? STEP : event.key === 'ArrowDown' ? -STEP : 0;
        if (step === 0) return;
        event.preventDefault();
        event.stopPropagation();
        setHeight(height.peek() + step);
      }}
    />
  );
}

function drag(event: PointerEvent): void {
  if (event.button !== 0) return;
  const began = height.peek();
  followPointer(event, (moved) => setHeight(began + (event.clientY - moved.clientY)));
}
