/** Observes a task: strokes, clicks, undo, levels, labels, playback, poses, times, and phases. */
import { Matrix4, type Quaternion, type Vector3, type WebGLRenderer } from 'three';
import type { Engine } from '../engine/engine';
import type { ClientMessage, StrokeBegin } from '../protocol/messages';
import type { LogRecord } from '../protocol/values';
import { type Pose, state } from '../store/state';
import { peek, watch } from '../store/watch';
import type { Headset } from '../xr/headset';
import { movedPose, sourceFrom } from './places';

/** Milliseconds from one pose to the next: 30 a second. */
const POSE_MS = 1000 / 30;
const SECOND_MS = 1000;
/** The view still counts as moving so long after it moved, milliseconds. */
const STILL_MS = 300;
/** A picture is late from this share of the usual time on. */
const LATE = 1.5;
/** Digits of a pose: tenths of a millimetre, and thousandths of a degree. */
const DIGITS = 5;

type Fields = Omit<LogRecord, 'step' | 't'>;
type Note = (fields: Fields) => void;

/** Observe a task; the result ends that. `worn`: no pose of the desk's camera belongs to it. */
export function observe(engine: Engine, headset: Headset, worn: boolean, note: Note): () => void {
  const { link, objects, viewer } = engine;
  link.observer = messageObserver(note);
  const clicked = (removes: boolean): void => {
    const shape = removes ? 'negative' : 'positive';
    note({ kind: 'click', shape, label: peek(state.activeLabel), frame: peek(state.frame) });
  };
  const stops = [
    () => (link.observer = null),
    objects.clicks.add(clicked),
    watch([state.object, state.activeLabel], choiceObserver(note)),
    // The desk at once, a headset when its session runs.
    watch([state.xr], () => note({ kind: 'device', profile: profileOf(viewer.renderer) })),
    viewer.ticks.add(timeObserver(note)),
    viewer.ticks.add(poseObserver(engine, headset, worn, note)),
  ];
  return () => stops.forEach((stop) => stop());
}

function strokeOf({ id, frame, brush }: StrokeBegin): Fields {
  const { tool = 'paint', shape = 'ray', label = 0 } = brush;
  return { kind: 'stroke', id, tool, shape, label, frame };
}

function messageObserver(note: Note): (message: ClientMessage) => void {
  let frame = peek(state.frame);
  const playback = (action: string, to: number): void => {
    frame = to;
    note({ kind: 'playback', action, frame });
  };
  return (message) => {
    const { type } = message;
    if (type === 'stroke_begin') note(strokeOf(message));
    else if (type === 'undo' || type === 'redo') note({ kind: type, id: message.id });
    else if (type === 'play' || type === 'pause')
      playback(type, message.frame ?? peek(state.frame));
    else if (type === 'seek') {
      const distance = Math.abs(message.frame - frame);
      // The same frame is asked for again when its surroundings change.
      if (distance > 0) playback(distance === 1 ? 'step' : 'seek', message.frame);
    }
  };
}

function choiceObserver(note: Note): () => void {
  let before = { label: peek(state.activeLabel), level: null as number | null };
  return () => {
    const { label, level } = before;
    before = { label: peek(state.activeLabel), level: peek(state.object)?.level ?? null };
    if (before.level !== level && before.level !== null)
      note({ kind: 'level', level: before.level });
    if (before.label !== label) note({ kind: 'label', label: before.label });
  };
}

/** Return properties of the desk, or of the headset whose session runs. */
function profileOf(renderer: WebGLRenderer): Record<string, string> {
  const session = renderer.xr.getSession();
  const gl = renderer.getContext();
  const sources = session ? [...session.inputSources] : [];
  return {
    agent: navigator.userAgent.slice(0, 300),
    gpu: String(gl.getParameter(gl.RENDERER)).slice(0, 300),
    size: `${innerWidth}x${innerHeight}`,
    headset: peek(state.xr).session,
    rate: String(session?.frameRate ?? ''),
    controllers: sources.map(({ profiles }) => profiles[0] ?? '').join(' '),
  };
}

/** Sum up the times between the pictures of each second. */
function timeObserver(note: Note): (now: number) => void {
  let intervals: number[] = [];
  let [last, second] = [NaN, NaN];
  return (now) => {
    if (now > last) intervals.push(now - last);
    last = now;
    if (now - second < SECOND_MS) return;
    second = now;
    const sorted = intervals.sort((a, b) => a - b);
    const { length } = sorted;
    intervals = [];
    if (length === 0) return;
    const mean_ms = sorted.reduce((sum, each) => sum + each, 0) / length;
    const dropped = sorted.filter((each) => each > LATE * sorted[length >> 1]!).length;
    note({ kind: 'frame_time', mean_ms, p95_ms: sorted[Math.floor(0.95 * length)]!, dropped });
  };
}

const rounded = (value: number): number => Number(value.toFixed(DIGITS));

function poseObserver(engine: Engine, headset: Headset, worn: boolean, note: Note) {
  const { room, camera } = engine.viewer;
  const observePhase = phaseObserver(engine, note);
  let posed = -Infinity;
  return (now: number): void => {
    if (now - posed < POSE_MS) return;
    posed = now;
    const { cockpit } = headset;
    observePhase(now, cockpit ? cockpit.rig.group.matrixWorld : camera.matrixWorld);
    const source = sourceFrom(room.matrixWorld, engine.shift());
    const of = (place: Vector3, turn: Quaternion): Pose =>
      movedPose(source, [...place.toArray(), ...turn.toArray()]).map(rounded) as never;
    const handOf = (side: 'left' | 'right'): Pose | null => {
      const hand = cockpit?.pointers.of(side);
      return hand?.tracked ? of(hand.place, hand.turn) : null;
    };
    if (cockpit) {
      const head = of(cockpit.rig.head, cockpit.rig.turned);
      note({ kind: 'pose', head, left: handOf('left'), right: handOf('right') });
    } else if (!worn) note({ kind: 'pose', head: of(camera.position, camera.quaternion) });
  };
}

/** Record changes of the phase: painting, moving the view or the room, or neither. */
function phaseObserver({ viewer, strokes }: Engine, note: Note) {
  const [viewBefore, roomBefore] = [new Matrix4(), new Matrix4()];
  let movedAt = -Infinity;
  let before: LogRecord['phase'] = null;
  return (now: number, view: Matrix4): void => {
    const room = viewer.room.matrixWorld;
    if (!viewBefore.equals(view) || !roomBefore.equals(room)) movedAt = now;
    viewBefore.copy(view);
    roomBefore.copy(room);
    const isMoving = now - movedAt < STILL_MS;
    const phase = strokes.drawing ? 'painting' : isMoving ? 'navigation' : 'waiting';
    if (phase !== before) note({ kind: 'phase', phase });
    before = phase;
  };
}
