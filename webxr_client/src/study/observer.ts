/** Observes a task: strokes, clicks, undo, levels, labels, playback, poses, times, and phases. */
import { Matrix4, type Quaternion, type Vector3 } from 'three';
import type { Engine } from '../engine/engine';
import type { ClientMessage } from '../protocol/messages';
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

const rounded = (value: number): number => Number(value.toFixed(DIGITS));

type Fields = Omit<LogRecord, 'step' | 't'>;

export class Observer {
  private readonly stops: (() => void)[];
  /** Times between the pictures of this second. */
  private intervals: number[] = [];
  private last = NaN;
  private posed = -Infinity;
  private second = NaN;
  private movedAt = -Infinity;
  private phase: LogRecord['phase'] = null;
  private frame = peek(state.frame);
  private label = peek(state.activeLabel);
  private level: number | null = null;
  /** View and room of the last pose. */
  private readonly before = [new Matrix4(), new Matrix4()] as const;

  /** `worn`: the task is done in the headset, so that the desk's camera is no pose of it. */
  constructor(
    private readonly engine: Engine,
    private readonly headset: Headset,
    private readonly worn: boolean,
    private readonly note: (fields: Fields) => void,
  ) {
    const { link, objects, viewer } = engine;
    link.observer = (message) => this.sent(message);
    this.stops = [
      () => (link.observer = null),
      objects.clicks.add((removes) => this.clicked(removes)),
      watch([state.object, state.activeLabel], () => this.chosen()),
      watch([state.xr], () => this.describe()),
      viewer.ticks.add((now) => this.picture(now)),
    ];
  }

  stop(): void {
    for (const stop of this.stops) stop();
  }

  private sent(message: ClientMessage): void {
    const { type } = message;
    if (type === 'stroke_begin') {
      const { id, frame, brush } = message;
      const { tool = 'paint', shape = 'ray', label = 0 } = brush;
      this.note({ kind: 'stroke', id, tool, shape, label, frame });
    } else if (type === 'undo' || type === 'redo') this.note({ kind: type, id: message.id });
    else if (type === 'play' || type === 'pause')
      this.playback(type, message.frame ?? peek(state.frame));
    else if (type === 'seek') {
      const distance = Math.abs(message.frame - this.frame);
      // The same frame is asked for again when its surroundings change.
      if (distance > 0) this.playback(distance === 1 ? 'step' : 'seek', message.frame);
    }
  }

  private playback(action: string, frame: number): void {
    this.frame = frame;
    this.note({ kind: 'playback', action, frame });
  }

  private clicked(removes: boolean): void {
    const shape = removes ? 'negative' : 'positive';
    this.note({ kind: 'click', shape, label: peek(state.activeLabel), frame: peek(state.frame) });
  }

  private chosen(): void {
    const level = peek(state.object)?.level ?? null;
    const label = peek(state.activeLabel);
    if (level !== null && level !== this.level) this.note({ kind: 'level', level });
    if (label !== this.label) this.note({ kind: 'label', label });
    [this.level, this.label] = [level, label];
  }

  /** Record the device: of the desk at once, of a headset when its session runs. */
  private describe(): void {
    const { renderer } = this.engine.viewer;
    const session = renderer.xr.getSession();
    const gl = renderer.getContext();
    const profiles = [...(session?.inputSources ?? [])].map((source) => source.profiles[0] ?? '');
    const profile = {
      agent: navigator.userAgent.slice(0, 300),
      gpu: String(gl.getParameter(gl.RENDERER)).slice(0, 300),
      size: `${innerWidth}x${innerHeight}`,
      headset: peek(state.xr).session,
      rate: String(session?.frameRate ?? ''),
      controllers: profiles.join(' '),
    };
    this.note({ kind: 'device', profile });
  }

  private picture(now: number): void {
    if (now > this.last) this.intervals.push(now - this.last);
    this.last = now;
    if (now - this.posed >= POSE_MS) this.pose(now);
    if (!(now - this.second < SECOND_MS)) this.sumUp(now);
  }

  private sumUp(now: number): void {
    const sorted = this.intervals.sort((a, b) => a - b);
    const { length } = sorted;
    this.intervals = [];
    this.second = now;
    if (length === 0) return;
    const mean_ms = sorted.reduce((sum, each) => sum + each, 0) / length;
    const dropped = sorted.filter((each) => each > LATE * sorted[length >> 1]!).length;
    this.note({ kind: 'frame_time', mean_ms, p95_ms: sorted[Math.floor(0.95 * length)]!, dropped });
  }

  private pose(now: number): void {
    this.posed = now;
    const { engine } = this;
    const { cockpit } = this.headset;
    const { room, camera } = engine.viewer;
    const source = sourceFrom(room.matrixWorld, engine.shift());
    const of = (place: Vector3, turn: Quaternion): Pose =>
      movedPose(source, [...place.toArray(), ...turn.toArray()]).map(rounded) as never;
    this.look(now, cockpit ? cockpit.rig.group.matrixWorld : camera.matrixWorld);
    if (cockpit) {
      const { pointers, rig } = cockpit;
      const [left, right] = (['left', 'right'] as const).map((side) => {
        const hand = pointers.of(side);
        return hand?.tracked ? of(hand.place, hand.turn) : null;
      });
      const head = of(rig.head, rig.turned);
      this.note({ kind: 'pose', head, left: left ?? null, right: right ?? null });
    } else if (!this.worn)
      this.note({ kind: 'pose', head: of(camera.position, camera.quaternion) });
  }

  /** Record a change of the phase: painting, moving the view or the room, or neither. */
  private look(now: number, view: Matrix4): void {
    const { viewer, strokes } = this.engine;
    const [viewBefore, roomBefore] = this.before;
    const room = viewer.room.matrixWorld;
    if (!viewBefore.equals(view) || !roomBefore.equals(room)) this.movedAt = now;
    viewBefore.copy(view);
    roomBefore.copy(room);
    const moves = now - this.movedAt < STILL_MS;
    const phase = strokes.drawing ? 'painting' : moves ? 'navigation' : 'waiting';
    if (phase !== this.phase) this.note({ kind: 'phase', phase });
    this.phase = phase;
  }
}
