/** Dispatch of the worker's messages: to the cache, the store, strokes, notices. */
import type { Following } from './following';
import { actions } from '../store/actions';
import type { CloudFrame } from '../cloud/points/frame';
import type { Viewer } from '../cloud/picture/viewer';
import { firstOf } from '../net/early';
import type { FromWorker, LabelUpdate, PlainMessage } from '../net/wire';
import type {
  Compiling,
  Error as ErrorMessage,
  Job,
  SequenceInfo,
  ServerPresence,
  Welcome,
} from '../protocol/messages';
import { takeBoxes } from '../store/boxes';
import { isActive, isMine, isTracking, notify, state } from '../store/state';
import type { ObjectTool } from '../tools/object';
import type { RegionPreview } from '../tools/region';
import type { Strokes } from '../tools/strokes';
import { takeLabels, takeTimeline } from './labels/labels';
import type { Playback } from './playback';
import { isOneOfSeveral } from './recordings/imports';
import { deletedByPage, leaveOut, noteJob, refreshSoon, waitedFor } from './recordings/recordings';
import { endRun } from './review';

export interface InboxDeps {
  readonly viewer: Viewer;
  readonly playback: Playback;
  readonly strokes: Strokes;
  readonly objects: ObjectTool;
  readonly regions: RegionPreview;
  readonly following: Following;
  /** A recording was opened that was not open before. */
  readonly opened: () => void;
  /** Recording that was opened while the page loaded, or null. */
  readonly opening: Promise<string | null>;
}

type Take<T> = (message: T) => void;
type Takes = { readonly [T in PlainMessage as T['type']]?: Take<T> };

function isOpen(sequence: string): boolean {
  return sequence === state.sequence.peek()?.id;
}

export class Inbox {
  /** Frames with provisional results of a tracking run. */
  private readonly provisional = new Set<CloudFrame>();

  private readonly takes: Takes = {
    welcome: (message) => this.welcome(message),
    sequence: (message) => this.takeSequence(message),
    labels: (message) => {
      if (isOpen(message.sequence)) takeLabels(message);
    },
    timeline: (message) => {
      const info = state.sequence.peek();
      if (info?.id === message.sequence) takeTimeline(message, info.frames);
    },
    boxes: (message) => {
      if (isOpen(message.sequence)) takeBoxes(message);
    },
    stroke_result: (message) => {
      this.deps.strokes.onResult(message);
      if (message.final) this.deps.objects.onResult(message.id);
    },
    candidates: (message) => {
      this.deps.objects.onCandidates(message);
      this.deps.regions.onCandidates(message);
    },
    prepared: ({ sequence, frame }) => {
      if (isOpen(sequence)) this.deps.objects.onPrepared(frame);
    },
    compiling: takeCompiling,
    job: (message) => this.takeJob(message),
    presence: takePresence,
    error: (message) => this.takeError(message),
  };

  constructor(private readonly deps: InboxDeps) {}

  receive(message: FromWorker): void {
    switch (message.t) {
      case 'segment':
        if (message.labels) this.takeLabelUpdate(message.labels);
        this.deps.playback.segment(message.segment);
        return;
      case 'labels':
        this.takeLabelUpdate(message.update);
        return;
      case 'link': {
        const retryAt = message.retryMs === null ? null : performance.now() + message.retryMs;
        const { unsent, detail } = message;
        state.connection.value = { state: message.state, detail, retryAt, unsent };
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
      // The end of a run may overtake its provisional results, which are void then.
      if (!state.jobs.peek().some((job) => job.sequence === update.sequence && isTracking(job)))
        return;
      const frame = this.deps.playback.store.get(update.frame);
      if (!frame) return;
      frame.mergeOverlay('provisional', update.lengths, update.values);
      this.provisional.add(frame);
      this.deps.viewer.invalidate();
      return;
    }
    this.deps.playback.labels(update);
    this.deps.objects.onLabels(update.frame);
    this.deps.regions.onLabels(update.frame);
    if (update.edit !== null) this.deps.strokes.drop(update.edit);
  }

  private takeMessage(message: PlainMessage): void {
    (this.takes[message.type] as Take<PlainMessage> | undefined)?.(message);
  }

  private welcome({ viewer, author, account, role, version }: Welcome): void {
    state.compiling.value = new Map();
    state.me.value = { viewer, author, account, role, serverVersion: version };
    this.deps.objects.restart();
    this.deps.regions.leave();
    this.deps.following.clear();
    void this.welcomed();
  }

  private takeError(message: ErrorMessage): void {
    const { about, closed, status, title, detail } = message;
    if (closed !== null) {
      this.sendOut(closed, detail);
      return;
    }
    if (about !== null) {
      this.deps.regions.onError(about);
      if (this.deps.following.refused(about)) return;
      const answered = this.deps.objects.onError(about, status);
      this.deps.strokes.drop(about);
      if (answered) return;
    }
    // A recording that does not exist is neither "opening" nor open.
    else if (state.opening.peek() !== null || status === 404) actions.recordings.closeSequence();
    // Nothing to undo is an answer, not a fault.
    notify(status === 409 ? 'info' : 'error', title, detail);
  }

  /** A recording was deleted while it is open here: back to the list, which lacks it by now. */
  private sendOut(sequence: string, detail: string): void {
    leaveOut(sequence);
    if (state.sequence.peek()?.id === sequence) actions.recordings.closeSequence();
    void actions.recordings.refreshSequences();
    if (!deletedByPage.has(sequence)) notify('info', 'The recording was closed', detail);
  }

  private async welcomed(): Promise<void> {
    await Promise.all([actions.recordings.refreshSequences(), this.deps.opening]);
    if (state.sequence.peek() || state.opening.peek() !== null) return;
    const first = firstOf(state.sequences.peek() ?? []);
    if (first !== null) actions.recordings.openSequence(first);
  }

  private takeSequence(info: SequenceInfo): void {
    const before = state.sequence.peek();
    const isSame = before?.id === info.id && before.identity === info.identity;
    state.sequence.value = info;
    state.opening.value = null;
    if (isSame) {
      // The link is back, or the name, rate or floor has changed: keep the loaded points.
      this.deps.playback.renew(info);
      if (state.playing.peek()) this.deps.playback.restart();
      else this.deps.playback.lookAround();
      return;
    }
    this.deps.playback.open(info);
    // The view stays where only the mounts of sensors have changed.
    if (before?.id !== info.id || info.sensors.length === 0) this.deps.opened();
    state.frame.value = info.frame;
  }

  private takeJob(job: Extract<PlainMessage, { type: 'job' }>): void {
    const known = state.jobs.peek().find((other) => other.id === job.id);
    noteJob(job);
    this.deps.following.job(job);
    if (isActive(job) || (known && !isActive(known)) || waitedFor.has(job.id)) return;
    if (isShownElsewhere(job)) {
      if (job.kind === 'import') refreshSoon();
      return;
    }
    if (job.kind === 'tracking') {
      this.dropProvisional();
      endRun(notifyRun(job));
    }
    if (job.state === 'failed') notify('error', `The ${job.kind} failed`, job.error ?? job.message);
    if (job.state === 'cancelled') notify('info', `The ${job.kind} was stopped`, kept(job));
    if (job.state === 'done') void this.jobDone(job);
  }

  private async jobDone(job: Extract<PlainMessage, { type: 'job' }>): Promise<void> {
    if (job.kind !== 'import') return;
    const before = new Set((state.sequences.peek() ?? []).map((entry) => entry.id));
    await actions.recordings.refreshSequences();
    const fresh = (state.sequences.peek() ?? []).find((entry) => !before.has(entry.id));
    offer(job.sequence ?? fresh?.id ?? null, fresh?.name ?? job.message);
  }

  private dropProvisional(): void {
    for (const frame of this.provisional) frame.dropOverlay('provisional');
    this.provisional.clear();
    this.deps.viewer.invalidate();
  }
}

/** Whether it is of another person in a recording that is not open, or on the card of imports. */
function isShownElsewhere(job: Job): boolean {
  return (!isMine(job) && job.sequence !== state.sequence.peek()?.id) || isOneOfSeveral(job);
}

/** Open an imported recording, or, with another recording on screen, offer a button to open it. */
function offer(id: string | null, name: string): void {
  if (id === null || state.sequence.peek() === null) {
    notify('success', 'Imported', name);
    if (id !== null) actions.recordings.openSequence(id);
    return;
  }
  const run = (): void => actions.recordings.openSequence(id);
  notify('success', 'Imported', name, { label: 'Open', run, stays: true });
}

/** Report a successful run; return the message's id, or null. */
function notifyRun(job: Extract<PlainMessage, { type: 'job' }>): number | null {
  return job.state === 'done' ? notify('success', 'Tracked', job.message) : null;
}

/** Return the message about the results that a stopped job keeps. */
function kept(job: Extract<PlainMessage, { type: 'job' }>): string {
  return job.kind === 'tracking' ? job.message : '';
}

function takeCompiling({ step, share }: Compiling): void {
  const steps = new Map(state.compiling.peek());
  if (share < 1) steps.set(step, share);
  else steps.delete(step);
  state.compiling.value = steps;
}

function takePresence(message: ServerPresence): void {
  const others = state.people.peek().filter((person) => person.viewer !== message.viewer);
  state.people.value = message.left ? others : [...others, message];
}
