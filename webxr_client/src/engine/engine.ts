/** The engine: connects socket, cache, picture, input and store.  The headset builds on it. */
import { effect } from '@preact/signals';
import { actions, bindActions, type TrackRequest, type ViewPreset } from '../actions';
import type { CloudFrame } from '../cloud/frame';
import { Viewer } from '../cloud/viewer';
import { DeskCamera } from '../desktop/camera';
import { viewOf } from '../desktop/framing';
import { listenToKeys } from '../desktop/keyboard';
import { DeskPointer } from '../desktop/pointer';
import { DeskPresence } from '../desktop/presence';
import { Link } from '../net/link';
import type { FromWorker, LabelUpdate, PlainMessage } from '../net/wire';
import type { Brush, SequenceInfo, ServerPresence } from '../protocol/messages';
import { dismiss, isActive, notify, state } from '../state';
import { Strokes, type Stroke } from '../tools/strokes';
import { brushActions, setRadius } from './brush';
import { Detail } from './detail';
import { labelActions, takeLabels, takeTimeline } from './labels';
import { Pacing } from './pacing';
import { Playback } from './playback';
import { noteJob, recordingActions } from './recordings';
import { reviewActions, runAsked, runEnded, unsure } from './review';
import { timeActions } from './time';

export class Engine {
  readonly viewer: Viewer;
  readonly link: Link;
  readonly playback: Playback;
  readonly strokes: Strokes;
  readonly pacing: Pacing;
  readonly camera: DeskCamera;
  private readonly pointer: DeskPointer;
  private readonly presence: DeskPresence;
  private readonly detail: Detail;
  /** The view must still be chosen for the recording just opened. */
  private unframed = false;
  /** Frames that show what a tracking run has found but not committed. */
  private readonly provisional = new Set<CloudFrame>();

  constructor(canvas: HTMLCanvasElement) {
    this.viewer = new Viewer(canvas);
    this.link = new Link((message) => this.receive(message));
    this.playback = new Playback(this.viewer, this.link);
    this.pacing = new Pacing(this.viewer, this.playback);
    this.strokes = new Strokes({
      send: (message) => this.link.send(message),
      locked: (label) => this.viewer.palette.isLocked(label),
      changed: () => this.viewer.invalidate(),
      now: () => performance.now(),
    });
    this.camera = new DeskCamera(this.viewer.camera);
    const frame = (): CloudFrame | null => this.playback.frame;
    const { viewer, camera, strokes } = this;
    this.pointer = new DeskPointer({ viewer, camera, strokes, frame });
    this.presence = new DeskPresence(this.link);
    this.detail = new Detail(this.viewer, this.playback, this.link);
    this.bind();
    this.follow();
    listenToKeys(this.camera);
  }

  start(): void {
    this.viewer.ticks.add((now) => this.tick(now));
    this.viewer.start();
    this.link.connect();
  }

  /** Begin a stroke on the frame that is on screen, or null when there is none. */
  beginStroke(brush: Brush): Stroke | null {
    const frame = this.playback.frame;
    const info = state.sequence.peek();
    return frame && info ? this.strokes.begin(frame, brush, info.shift) : null;
  }

  private tick(now: number): void {
    this.playback.update();
    this.strokes.flush();
    this.pacing.update(now);
    const { isPresenting } = this.viewer.renderer.xr;
    // At the desk more is kept than is drawn while something moves; a head always moves.
    this.detail.update(now, isPresenting ? this.pacing.points : Infinity);
    if (isPresenting) return;
    if (this.unframed && this.playback.frame) this.viewFrom('sensor', true);
    if (this.camera.update(now)) {
      this.pointer.refresh();
      this.viewer.invalidate();
    }
    this.pointer.update();
    this.presence.update(now, this.pointer.brushAt);
  }

  // ── the store drives the picture ───────────────────────────────────────────────────────────

  private follow(): void {
    effect(() => {
      this.viewer.palette.set(state.palette.value, state.solo.value, unsure.value);
      this.viewer.invalidate();
    });
    effect(() => {
      this.viewer.setView(state.view.value, state.sequence.value?.fields ?? []);
    });
    effect(() => {
      brushInputs();
      this.pointer.refresh();
    });
  }

  // ── what the worker brings ─────────────────────────────────────────────────────────────────

  private receive(message: FromWorker): void {
    switch (message.t) {
      case 'segment':
        this.playback.segment(message.segment);
        return;
      case 'labels':
        this.takeLabelUpdate(message.update);
        return;
      case 'link': {
        const retryAt = message.retryMs === null ? null : performance.now() + message.retryMs;
        state.connection.value = { state: message.state, detail: message.detail, retryAt };
        return;
      }
      case 'pending':
        state.pending.value = message.count;
        return;
      case 'message':
        this.takeMessage(message.message);
    }
  }

  private takeLabelUpdate(update: LabelUpdate): void {
    if (update.sequence !== state.sequence.peek()?.id) return;
    if (update.provisional) {
      const frame = this.playback.store.get(update.frame);
      if (!frame) return;
      frame.mergeOverlay('provisional', update.lengths, update.values);
      this.provisional.add(frame);
      this.viewer.invalidate();
      return;
    }
    this.playback.labels(update);
    if (update.edit !== null) this.strokes.drop(update.edit);
  }

  private takeMessage(message: PlainMessage): void {
    switch (message.type) {
      case 'welcome': {
        const { viewer, author, role, version } = message;
        state.me.value = { viewer, author, role, serverVersion: version };
        void this.welcomed();
        return;
      }
      case 'sequence':
        this.takeSequence(message);
        return;
      case 'labels':
        if (message.sequence === state.sequence.peek()?.id) takeLabels(message);
        return;
      case 'timeline': {
        const info = state.sequence.peek();
        if (info?.id === message.sequence) takeTimeline(message, info.frames);
        return;
      }
      case 'stroke_result':
        this.strokes.onResult(message);
        return;
      case 'job':
        this.takeJob(message);
        return;
      case 'presence':
        takePresence(message);
        return;
      case 'error':
        if (message.about !== null) this.strokes.drop(message.about);
        // A recording that is not there (any more) does not stay "opening" for ever.
        else if (state.opening.peek() !== null) this.closeSequence();
        // Nothing to undo is an answer, not a fault.
        notify(message.status === 409 ? 'info' : 'error', message.title, message.detail);
    }
  }

  private async welcomed(): Promise<void> {
    await actions.refreshSequences();
    if (state.sequence.peek()) return;
    const list = state.sequences.peek() ?? [];
    const wanted = new URLSearchParams(location.search).get('sequence');
    const first = list.find((entry) => entry.id === wanted) ?? (list.length === 1 ? list[0] : null);
    if (first) this.openSequence(first.id);
  }

  private takeSequence(info: SequenceInfo): void {
    const before = state.sequence.peek();
    const again = before?.id === info.id && before.frames === info.frames;
    state.sequence.value = info;
    state.opening.value = null;
    if (again) {
      // The link came back: what is here stays, and time goes on where it was.
      if (state.playing.peek()) this.playback.restart();
      else this.link.send({ type: 'seek', frame: state.frame.peek() });
      return;
    }
    this.playback.open(info);
    this.pacing.reset();
    this.unframed = true;
    state.frame.value = info.frame;
  }

  private takeJob(job: Extract<PlainMessage, { type: 'job' }>): void {
    const known = state.jobs.peek().find((other) => other.id === job.id);
    noteJob(job);
    if (isActive(job) || (known && !isActive(known))) return;
    if (job.kind === 'tracking') {
      this.dropProvisional();
      runEnded();
    }
    if (job.state === 'failed') notify('error', `The ${job.kind} failed`, job.error ?? job.message);
    if (job.state === 'cancelled') notify('info', `The ${job.kind} was stopped`);
    if (job.state === 'done') void this.jobDone(job);
  }

  private async jobDone(job: Extract<PlainMessage, { type: 'job' }>): Promise<void> {
    if (job.kind === 'tracking') notify('success', 'Tracked', job.message);
    if (job.kind !== 'import') return;
    const before = new Set((state.sequences.peek() ?? []).map((entry) => entry.id));
    await actions.refreshSequences();
    const fresh = (state.sequences.peek() ?? []).find((entry) => !before.has(entry.id));
    notify('success', 'Imported', fresh?.name ?? job.message);
    const id = job.sequence ?? fresh?.id;
    if (id && !state.sequence.peek()) this.openSequence(id);
  }

  private dropProvisional(): void {
    for (const frame of this.provisional) frame.dropOverlay('provisional');
    this.provisional.clear();
    this.viewer.invalidate();
  }

  // ── actions ────────────────────────────────────────────────────────────────────────────────

  private bind(): void {
    bindActions(recordingActions);
    bindActions(labelActions);
    bindActions(brushActions);
    bindActions(reviewActions);
    bindActions(timeActions(this.playback));
    bindActions({
      viewFrom: (preset) => this.viewFrom(preset),
      undo: () => this.link.send({ type: 'undo', id: crypto.randomUUID() }),
      redo: () => this.link.send({ type: 'redo', id: crypto.randomUUID() }),
      track: (request) => this.track(request),
      openSequence: (id) => this.openSequence(id),
      closeSequence: () => this.closeSequence(),
      reconnect: () => this.link.connect(),
      dismissNotice: dismiss,
    });
  }

  viewFrom(preset: ViewPreset, jump = false): void {
    const info = state.sequence.peek();
    const frame = this.playback.frame;
    if (!info || !frame) return;
    this.unframed = false;
    const [low, high] = this.viewer.bounds(info);
    const { camera, room } = this.viewer;
    const view = viewOf(preset, frame, room.matrix, camera.fov, camera.aspect);
    if (!view) return;
    const { eye, target } = view;
    const size = low.distanceTo(high);
    camera.near = Math.min(0.05, Math.max(0.01, size / 2000)) * (size > 200 ? 10 : 1);
    camera.far = Math.max(100, size * 6);
    camera.updateProjectionMatrix();
    this.camera.walkSpeed = Math.max(0.5, size / 8);
    // A brush for what one sees: 5 cm in a room, as much larger in a street.
    if (jump) setRadius(Math.min(1, Math.max(0.02, eye.distanceTo(target) / 60)));
    this.camera.lookAt(eye, target, jump);
    this.viewer.invalidate();
  }

  private track(request: TrackRequest): void {
    this.playback.pause();
    runAsked(request);
    const { labels, ...rest } = request;
    const id = crypto.randomUUID();
    this.link.send({ type: 'track', id, labels: labels && [...labels], ...rest });
  }

  private openSequence(id: string): void {
    if (state.sequence.peek()?.id === id) return;
    this.closeSequence();
    state.opening.value = id;
    const url = new URL(location.href);
    url.searchParams.set('sequence', id);
    history.replaceState(null, '', url);
    this.link.open({ type: 'open', sequence: id, frame: 0, revision: null });
  }

  private closeSequence(): void {
    this.link.close();
    this.playback.close();
    state.playing.value = false;
    state.sequence.value = null;
    state.opening.value = null;
    state.frame.value = 0;
    state.palette.value = [];
    state.counts.value = new Map();
    state.timeline.value = { rows: new Map() };
    state.loaded.value = [];
    state.solo.value = null;
    state.undo.value = state.redo.value = null;
    state.history.value = [];
  }
}

/** What decides how the brush looks where it is: read, so that an effect follows it. */
function brushInputs(): readonly unknown[] {
  const { tool, brush, activeLabel, palette, shown } = state;
  return [tool.value, brush.value, activeLabel.value, palette.value, shown.value];
}

function takePresence(message: ServerPresence): void {
  const others = state.people.peek().filter((person) => person.viewer !== message.viewer);
  state.people.value = message.left ? others : [...others, message];
}
