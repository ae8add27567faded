/** A participant's step again: ghost of head and hands, frames, and labels as they were. */
import { computed, signal } from '@preact/signals';
import { zipSync } from 'three/examples/jsm/libs/fflate.module.js';
import { LABEL_COLORS } from '../common/colors';
import type { Engine } from '../engine/engine';
import { attempt } from '../engine/recordings/recordings';
import { saveBlob } from '../net/files';
import { api, apiBytes } from '../net/rest';
import type { LogRecord, PastEdit } from '../protocol/values';
import { actions } from '../store/actions';
import { type Pose, state } from '../store/state';
import { labelsOf } from '../work/shown-copies';
import { movedPose, sourceFrom } from './places';

/** Most edits of one answer. */
const MOST_EDITS = 1000;
/** Pictures of a second as it is replayed, and most of a file. */
const [PICTURES_HZ, MOST_PICTURES] = [10, 1200];
const GHOST = { viewer: 'replay', color: LABEL_COLORS[6], label: 0, radius: 0, brush: null };

/** Milliseconds since the step began. */
export const time = signal(0);
export const plays = signal(false);
export const speed = signal(1);
const records = signal<readonly LogRecord[]>([]);
export const duration = computed(() => records.value.at(-1)?.t ?? 0);

export class Replay {
  private readonly unsubscribe: () => void;
  private sequence = '';
  /** Revision after each edit of the step, by the edit's id. */
  private revisions = new Map<string, number>();
  private last = NaN;
  /** Recording, frame, revision and points to show, and the shown ones. */
  private wanted = '';
  private applied = '';
  private fetching = false;
  /** The pose that is shown. */
  private pose: LogRecord | undefined;

  constructor(
    private readonly engine: Engine,
    private readonly name: string,
  ) {
    this.unsubscribe = engine.viewer.ticks.add((now) => this.tick(now));
  }

  /** Open the recording of a step, and go to its beginning. */
  async open(sequence: string, log: readonly LogRecord[]): Promise<void> {
    records.value = [];
    this.revisions = await revisionsOf(sequence);
    this.sequence = sequence;
    records.value = [...log].sort((a, b) => a.t - b.t);
    time.value = records.value[0]?.t ?? 0;
    actions.recordings.openSequence(sequence);
  }

  stop(): void {
    this.unsubscribe();
    plays.value = false;
    state.people.value = [];
    // It shows labels of the past.
    actions.recordings.closeSequence();
  }

  private tick(now: number): void {
    const passed = now - this.last;
    this.last = now;
    if (state.sequence.peek()?.id !== this.sequence) return;
    if (plays.peek()) {
      time.value = Math.min(duration.peek(), time.peek() + passed * speed.peek());
      plays.value = time.peek() < duration.peek();
    }
    const frame = this.frame();
    if (frame !== state.frame.peek()) actions.time.seek(frame);
    this.showBody(frame);
    this.showLabels(frame);
  }

  private frame(): number {
    const t = time.peek();
    const moved = newest(t, ({ kind, frame }) => kind === 'playback' && typeof frame === 'number');
    const { fps = 1, frames = 1 } = state.sequence.peek() ?? {};
    const since = moved?.action === 'play' ? Math.floor(((t - moved.t) * fps) / 1000) : 0;
    return ((moved?.frame ?? state.frame.peek()) + since) % frames;
  }

  private showBody(frame: number): void {
    const { engine, name } = this;
    const pose = newest(time.peek(), ({ kind }) => kind === 'pose');
    if (pose === this.pose) return;
    this.pose = pose;
    const toRoom = sourceFrom(engine.viewer.room.matrix, engine.shift()).invert();
    const at = (logged: LogRecord['head']): Pose | null =>
      logged ? movedPose(toRoom, logged) : null;
    const hands = [at(pose?.left), at(pose?.right)] as [Pose | null, Pose | null];
    state.people.value = [{ ...GHOST, name, frame, head: at(pose?.head), hands }] as never;
  }

  private showLabels(frame: number): void {
    const edit = newest(time.peek(), ({ id }) => this.revisions.has(id ?? ''));
    const revision = this.revisions.get(edit?.id ?? '') ?? 0;
    const points = this.engine.playback.frame;
    // Points that come anew have the newest labels.
    this.wanted = `${this.sequence} ${frame} ${revision} ${points?.pointsVersion ?? -1}`;
    const ready = points?.index === frame && points.complete && !this.fetching;
    if (ready && this.wanted !== this.applied) void this.fetch(frame, revision, points.total);
  }

  /** Fetch the labels of a frame as they were, and apply them. */
  private async fetch(frame: number, revision: number, count: number): Promise<void> {
    const { wanted, sequence } = this;
    this.fetching = true;
    await attempt('The labels of that time did not load', async () => {
      const path = `sequences/${sequence}/frames/${frame}/annotation?order=stored&revision=${revision}`;
      const values = labelsOf(await apiBytes('GET', path, undefined, new AbortController().signal));
      const lengths = new Uint32Array(count).fill(1);
      const whole = { base: null, edit: null, provisional: false, first: 0, count };
      this.engine.playback.labels({ sequence, frame, revision, ...whole, lengths, values });
    });
    this.applied = wanted;
    this.fetching = false;
  }

  /** Save pictures of the whole step at its speed as a zip; `progress` gets the done share, 0..1. */
  async save(progress: (share: number) => void): Promise<void> {
    plays.value = false;
    const files: Record<string, Uint8Array> = {};
    const step = Math.max((1000 * speed.peek()) / PICTURES_HZ, duration.peek() / MOST_PICTURES);
    for (let t = 0, k = 0; t <= duration.peek(); t += step, k++) {
      time.value = t;
      files[`${String(k).padStart(5, '0')}.png`] = await this.picture();
      progress(t / duration.peek());
    }
    // A PNG is compressed already.
    saveBlob(`${this.name}.zip`, new Blob([zipSync(files, { level: 0 })]));
  }

  /** Return the canvas as a PNG once it shows the current time. */
  private async picture(): Promise<Uint8Array> {
    const { viewer, playback } = this.engine;
    const blob = await new Promise<Blob | null>((resolve) => {
      let waits = 2;
      const stop = viewer.ticks.add(() => {
        viewer.invalidate();
        const settled = this.applied === this.wanted && playback.frame?.complete;
        // The time is taken in before the first of two pictures.
        if (!settled || waits-- > 0) return;
        stop();
        // The browser empties the canvas once it was shown: it is read just after it was drawn.
        queueMicrotask(() => viewer.canvas.toBlob(resolve));
      });
    });
    if (!blob) throw new Error('The browser made no picture of the canvas.');
    return new Uint8Array(await blob.arrayBuffer());
  }
}

/** Return the revision after each edit of a recording, by the edit's id. */
async function revisionsOf(sequence: string): Promise<Map<string, number>> {
  const found = new Map<string, number>();
  for (let page = MOST_EDITS, before = ''; page === MOST_EDITS;) {
    const path = `sequences/${sequence}/edits?limit=${MOST_EDITS}${before}`;
    const edits = await api<PastEdit[]>('GET', path);
    for (const { id, revision } of edits) found.set(id, revision);
    before = `&before=${edits.at(-1)?.revision}`;
    page = edits.length;
  }
  return found;
}

/** Return the newest record up to a time that meets a condition. */
function newest(t: number, meets: (record: LogRecord) => boolean): LogRecord | undefined {
  return records.peek().findLast((record) => record.t <= t && meets(record));
}
