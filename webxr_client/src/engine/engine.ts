/** The engine: connects socket, cache, picture, input and store.  The headset builds on it. */
import { computed } from '@preact/signals';
import type { Vec } from '../store/types';
import { actions, bindActions, type TrackRequest, type ViewPreset } from '../store/actions';
import { layers } from '../cloud/points/accumulation';
import { ALL_POINTS, type CloudFrame } from '../cloud/points/frame';
import { Viewer } from '../cloud/picture/viewer';
import { DeskCamera } from '../view/camera';
import { underCeiling } from '../view/ceiling';
import { isPlan, viewOf } from '../view/framing';
import { clip, type Clip } from '../tools/clip';
import type { Vector3 } from 'three';
import { Listeners } from '../store/listeners';
import { nameInAddress, type Early } from '../net/early';
import type { Link } from '../net/link';
import type { FromWorker } from '../net/wire';
import type { Brush, ClientMessage } from '../protocol/messages';
import { activeLabel as active, dismiss, isActive, state } from '../store/state';
import { locallyHiddenLabels, seenIn } from '../tools/seen';
import { brushNow } from '../tools/brush';
import { ObjectTool } from '../tools/object';
import { RegionPreview } from '../tools/region';
import { Strokes, type Stroke } from '../tools/strokes';
import { roomWay, wayOf } from '../tools/ways';
import { colouredLabels } from './labels/colouring';
import { forgetBoxes } from '../store/boxes';
import { colourFields, hiddenSensors, sensors } from '../store/sensors';
import { theme } from '../store/theme';
import { follow, watch } from '../store/watch';
import { openBookmarks } from '../view/bookmarks';
import { Accumulated } from './accumulated';
import { Address } from '../view/address';
import { brushActions, setRadius } from './brush';
import { loadCategories } from './labels/categories';
import { Detail } from './detail';
import { floorActions } from './floor';
import { Following } from './following';
import { Inbox } from './inbox';
import { labelActions } from './labels/labels';
import { Pacing } from './pacing';
import { Playback } from './playback';
import { recordingActions } from './recordings/recordings';
import { forgetRun, reviewActions, startRun, unsure } from './review';
import { showTravel, timeActions } from './time';

const openedId = computed(() => state.sequence.value?.id ?? null);

/** Run something once it is time; the result forgets it. */
function later(run: () => void, milliseconds: number): () => void {
  const timer = setTimeout(run, milliseconds);
  return () => clearTimeout(timer);
}

export class Engine {
  readonly viewer: Viewer;
  readonly link: Link;
  readonly playback: Playback;
  readonly strokes: Strokes;
  readonly objects: ObjectTool;
  private readonly following: Following;
  readonly regions: RegionPreview;
  readonly pacing: Pacing;
  readonly camera: DeskCamera;
  private readonly address: Address;
  private readonly detail: Detail;
  private readonly accumulated: Accumulated;
  /** The clip that keeps a ceiling out of a plan. */
  private cut: Clip | null = null;
  /** The frame on screen. */
  readonly frame = (): CloudFrame | null => this.playback.frame;
  /** Source minus local coordinates. */
  readonly shift = (): Vec => state.sequence.peek()?.shift ?? [0, 0, 0];
  private readonly send = (message: ClientMessage): void => this.link.send(message);
  readonly changed = (): void => this.viewer.invalidate();
  /** Whether a label's points stay as they are. */
  readonly locked = (label: number): boolean => this.viewer.palette.isSpared(label);

  constructor(canvas: HTMLCanvasElement, early: Early) {
    this.link = early.link;
    this.viewer = new Viewer(canvas);
    this.playback = new Playback(this.viewer, this.link);
    this.pacing = new Pacing(this.viewer, this.playback);
    this.strokes = this.makeStrokes();
    this.camera = new DeskCamera(this.viewer.camera);
    this.address = new Address(this.camera);
    this.objects = this.makeObjects();
    this.following = this.makeFollowing();
    const { frame, shift, changed, send } = this;
    const brush = (): Brush | null => brushNow(roomWay(), state.brush.peek().radius);
    this.regions = new RegionPreview({ send, frame, shift, changed, brush });
    this.detail = new Detail(this.viewer, this.playback, this.link);
    this.accumulated = new Accumulated(this.viewer, this.playback);
    this.bind();
    this.listen(early.opening);
    this.follow();
  }

  private makeStrokes(): Strokes {
    return new Strokes({
      send: this.send,
      locked: this.locked,
      seen: seenIn(this.viewer.palette),
      hidden: locallyHiddenLabels,
      layers: () => layers.peek(),
      changed: this.changed,
      now: () => performance.now(),
    });
  }

  private makeObjects(): ObjectTool {
    const { send, strokes, frame, changed, shift } = this;
    const brush = (): Brush | null => brushNow(wayOf('object'), state.brush.peek().radius);
    return new ObjectTool({ send, strokes, frame, changed, shift, brush, later });
  }

  private makeFollowing(): Following {
    const { send, strokes } = this;
    const following = new Following({
      send,
      later,
      last: () => (state.sequence.peek()?.frames ?? 1) - 1,
      cancel: (job) => void actions.tracking.cancelJob(job),
      on: () => state.brush.peek().follow,
      busy: () => strokes.drawing || state.jobs.peek().some(isActive),
    });
    strokes.begins.add(({ id, brush }) => following.begin(id, brush));
    strokes.results.add((result) => following.result(result));
    return following;
  }

  /** `opening`: the recording that is opened while the page loads, or null. */
  private listen(opening: Promise<string | null>): void {
    const { viewer, playback, strokes, objects, regions, following, link } = this;
    const parts = { viewer, playback, strokes, objects, regions, following };
    const opened = (): void => {
      this.pacing.reset();
      state.framed.value = false;
    };
    const inbox = new Inbox({ ...parts, opened, opening });
    void opening.then((id) => {
      if (state.sequence.peek() === null) state.opening.value = id;
    });
    const messageListeners = new Listeners<FromWorker>();
    messageListeners.add((message) => inbox.receive(message));
    link.listen((message) => messageListeners.run(message));
  }

  start(): void {
    const { ticks } = this.viewer;
    ticks.add((now) => this.playback.update(now));
    ticks.add(() => this.accumulated.update());
    ticks.add(() => {
      if (this.strokes.show()) this.viewer.afterwards.ask();
    });
    ticks.add((now) => this.tune(now));
    ticks.add((now) => this.tickDesk(now));
    this.viewer.afterwards.runs.add(() => this.strokes.send());
    this.viewer.start();
  }

  /** Begin a stroke on the frame that is on screen, or null when there is none. */
  beginStroke(brush: Brush): Stroke | null {
    const frame = this.playback.frame;
    const info = state.sequence.peek();
    return frame && info ? this.strokes.begin(frame, brush, info.shift) : null;
  }

  /** As many points as can be drawn in time. */
  private tune(now: number): void {
    this.pacing.update(now);
    const { isPresenting } = this.viewer.renderer.xr;
    // The desk keeps more points than it draws during motion; a headset is always in motion.
    this.detail.update(now, isPresenting ? this.pacing.points : ALL_POINTS);
  }

  private tickDesk(now: number): void {
    if (this.viewer.renderer.xr.isPresenting) return;
    if (!state.framed.peek() && this.playback.frame) {
      this.viewFrom('sensor', true);
      this.address.framed();
    }
    this.address.update(now);
  }

  // ── the store drives the picture ───────────────────────────────────────────────────────────

  private follow(): void {
    follow(() => {
      this.viewer.palette.set(colouredLabels(), state.solo.value, unsure.value);
      this.viewer.invalidate();
    });
    follow(() => {
      const view = state.view.value;
      // Restored points must be seen.
      const showDeleted = view.showDeleted || state.tool.value === 'restore';
      this.viewer.setView({ ...view, showDeleted }, colourFields.value);
    });
    follow(() => {
      const colors = sensors.value.map(({ color }) => color);
      this.viewer.palette.setSensors(colors, hiddenSensors.value);
      this.viewer.uniforms.setSeveralSensors(colors.length > 0);
      this.viewer.invalidate();
    });
    follow(() => {
      // A headset's room stays dark: a bright sky all around dazzles.
      this.viewer.backdrop.setLight(
        theme.value === 'light' && state.xr.value.session !== 'running',
      );
      this.viewer.invalidate();
    });
    follow(() => this.viewer.setOutlined('object', (state.object.value?.levels ?? 0) > 0));
    follow(() => this.viewer.palette.setPreview(active.value?.color ?? '#ffffff'));
    watch([state.brush, state.activeLabel, state.frame, state.sequence], () => {
      this.objects.end();
      this.regions.leave();
    });
    watch([openedId], () => void loadCategories());
    follow(() => openBookmarks(state.sequence.value?.id ?? null));
    watch([state.tool], () => {
      this.objects.onToolChange(state.tool.peek());
      this.regions.leave();
    });
  }

  // ── actions ────────────────────────────────────────────────────────────────────────────────

  private bind(): void {
    bindActions(recordingActions);
    bindActions(labelActions);
    bindActions(brushActions);
    bindActions(reviewActions);
    bindActions(floorActions);
    bindActions(timeActions(this.playback));
    bindActions({
      view: { viewFrom: (preset) => this.viewFrom(preset) },
      history: { undo: () => this.travel('undo'), redo: () => this.travel('redo') },
      tools: {
        stepObject: (levels) => this.objects.step(levels),
        completeObject: () => this.objects.accept(),
        endObject: () => this.objects.end(),
      },
      tracking: { track: (request) => this.track(request) },
      recordings: {
        openSequence: (id) => this.openSequence(id),
        closeSequence: () => this.closeSequence(),
      },
      page: { reconnect: () => this.link.connect(), dismissNotice: dismiss },
    });
  }

  private travel(type: 'undo' | 'redo'): void {
    if (!state.sequence.peek()) return;
    this.objects.end();
    const edits = type === 'undo' ? this.following.undo() : 1;
    for (let k = 0; k < edits; k++) {
      const id = crypto.randomUUID();
      this.link.send({ type, id });
      showTravel(type, id);
    }
  }

  viewFrom(preset: ViewPreset, jump = false): void {
    const info = state.sequence.peek();
    const frame = this.playback.frame;
    if (!info || !frame) return;
    state.framed.value = true;
    const [low, high] = this.viewer.bounds(info);
    const { camera, room } = this.viewer;
    const view = viewOf(preset, frame, room.matrix, camera.fov, camera.aspect, info.shift);
    if (!view) return;
    const { eye, target } = view;
    const size = low.distanceTo(high);
    camera.near = Math.min(0.05, Math.max(0.01, size / 2000)) * (size > 200 ? 10 : 1);
    camera.far = Math.max(100, size * 6);
    camera.updateProjectionMatrix();
    this.camera.walkSpeed = Math.max(0.5, size / 8);
    this.camera.depth = Math.max(10, 2 * size);
    // The brush fits the view: 5 cm in a room, proportionally larger in a street.
    if (jump) setRadius(Math.min(1, Math.max(0.02, eye.distanceTo(target) / 60)));
    this.cutCeiling(preset === 'top' ? underCeiling(frame, room.matrix) : null, low, high);
    this.camera.lookAt(eye, target, jump, isPlan(preset));
    this.viewer.invalidate();
  }

  /** Show only points below a height; null: all.  A clip box that the user made stays. */
  private cutCeiling(height: number | null, low: Vector3, high: Vector3): void {
    if (clip.peek() !== null && clip.peek() !== this.cut) return;
    const [x, z] = [(low.x + high.x) / 2, (low.z + high.z) / 2];
    const wide = low.distanceTo(high);
    const bottom = low.y - 1;
    this.cut =
      height === null
        ? null
        : {
            volume: {
              center: [x, (bottom + height) / 2, z],
              size: [wide, height - bottom, wide],
              yaw: 0,
            },
            slab: 1,
            follows: false,
          };
    clip.value = this.cut;
  }

  private track(request: TrackRequest): void {
    this.playback.pause();
    startRun(request);
    this.link.send({ type: 'track', id: crypto.randomUUID(), ...request });
  }

  private openSequence(id: string): void {
    if (state.sequence.peek()?.id === id) return;
    this.closeSequence();
    state.opening.value = id;
    nameInAddress(id);
    const message = { type: 'open', sequence: id, frame: 0, revision: null } as const;
    this.link.post({ t: 'open', message });
  }

  private closeSequence(): void {
    nameInAddress(null);
    this.following.clear();
    this.link.post({ t: 'close' });
    this.playback.close();
    forgetRun();
    forgetBoxes();
    state.playing.value = false;
    state.sequence.value = null;
    state.opening.value = null;
    state.frame.value = 0;
    state.palette.value = [];
    state.counts.value = new Map();
    state.timeline.value = { rows: new Map() };
    state.loaded.value = [];
    state.solo.value = null;
    hiddenSensors.value = new Set();
    state.undo.value = state.redo.value = null;
    state.history.value = [];
  }
}
