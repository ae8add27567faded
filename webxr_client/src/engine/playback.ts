/** Time: the playhead, the clock, the frame on screen, and the cached frames. */
import { PlayClock } from '../cloud/picture/clock';
import type { CloudFrame } from '../cloud/points/frame';
import { FrameStore } from '../cloud/points/store';
import type { Viewer } from '../cloud/picture/viewer';
import { Listeners } from '../store/listeners';
import { frameRange, ordered } from '../store/range';
import type { Link } from '../net/link';
import { buffersOf, type Segment } from '../net/chunk/segment';
import type { LabelUpdate, Pace } from '../net/wire';
import type { SequenceInfo } from '../protocol/messages';
import { peek } from '../store/watch';
import { state } from '../store/state';

/** Part of the device's memory (its own figure, GiB; a headset has 8) for cached frames. */
const CACHE_BYTES = 0.09 * 2 ** 30 * ((navigator as { deviceMemory?: number }).deviceMemory ?? 4);

/** Return the frame at which playing goes on: the other end, once it leaves the looped stretch. */
function looped(frame: number, direction: 1 | -1): number {
  const range = peek(frameRange);
  if (!range || !peek(state.loop)) return frame;
  const [first, last] = ordered(range);
  if (first === last || (frame >= first && frame <= last)) return frame;
  return direction > 0 ? first : last;
}

export class Playback {
  store = new FrameStore(1, false, CACHE_BYTES);
  /** Frame messages taken in since the page began, and their bytes. */
  readonly counters = { applied: 0, points: 0, bytes: 0, dropped: 0, decodeMs: 0 };
  /** Points of a playing frame that can be drawn in time, or null. */
  pointBudget: number | null = null;
  /** Frames that are laid over one when it is shown: sent with it, and kept. */
  around: (frame: number) => number[] = () => [];
  /** Called with each frame that has become complete. */
  readonly completed = new Listeners<CloudFrame>();
  private info: SequenceInfo | null = null;
  private readonly clock = new PlayClock();
  private shown: CloudFrame | null = null;
  private shownVersion = -1;
  private shownLabels = -1;
  private rangesVersion = -1;
  private ranges = 0;

  constructor(
    private readonly viewer: Viewer,
    private readonly link: Link,
  ) {}

  /** The frame on screen. */
  get frame(): CloudFrame | null {
    return this.shown;
  }

  open(info: SequenceInfo): void {
    this.close();
    this.info = info;
    this.store = new FrameStore(info.frames, info.large, CACHE_BYTES);
    this.viewer.setSequence(info);
  }

  /** The same recording, with another name, rate or floor. */
  renew(info: SequenceInfo): void {
    this.info = info;
    this.viewer.stand(info);
  }

  close(): void {
    for (const frame of this.store.all()) this.link.recycle(frame.release());
    this.store = new FrameStore(1, false, CACHE_BYTES);
    this.info = null;
    this.shown = null;
    this.rangesVersion = -1;
    this.viewer.setSequence(null);
    state.shown.value = { frame: -1, points: 0, total: 0 };
  }

  // ── the user's wishes ──────────────────────────────────────────────────────────────────────

  play(): void {
    const { info } = this;
    if (!info || info.frames < 2) return;
    const speed = peek(state.speed);
    let frame = peek(state.frame);
    // Play at the end of a recording that does not loop starts over.
    if (!peek(state.loop) && speed > 0 && frame === info.frames - 1) frame = 0;
    state.frame.value = frame;
    state.playing.value = true;
    this.restart();
  }

  /** (Re)start the clock where the playhead is; also after a change of speed or of the link. */
  restart(): void {
    const { info } = this;
    if (!info || !peek(state.playing)) return;
    const frame = peek(state.frame);
    const [speed, loop] = [peek(state.speed), peek(state.loop)];
    this.clock.begin(frame, info.fps, speed, info.frames, loop, performance.now());
    this.link.send({ type: 'play', frame, speed, loop });
  }

  /** Stop at a frame, by default at the one on screen. */
  pause(at = this.shown?.index ?? peek(state.frame)): void {
    if (!peek(state.playing)) return;
    state.playing.value = false;
    state.frame.value = at;
    // The budget of a playing frame no longer counts.
    if (this.pointBudget !== null) this.link.post({ t: 'pace', pace: this.pace() });
    this.link.send({ type: 'pause', frame: peek(state.frame) });
    this.lookAround();
    this.sync();
  }

  seek(frame: number): void {
    const { info } = this;
    if (!info) return;
    const to = Math.min(info.frames - 1, Math.max(0, Math.round(frame)));
    state.frame.value = to;
    if (peek(state.playing)) {
      this.restart();
      return;
    }
    this.sendSeek();
    this.sync();
  }

  /** Show other frames over the one on screen. */
  lookAround(): void {
    if (this.info && !peek(state.playing)) this.sendSeek();
  }

  private sendSeek(): void {
    const frame = peek(state.frame);
    this.link.send({ type: 'seek', frame, around: this.around(frame) });
  }

  // ── incoming messages ──────────────────────────────────────────────────────────────────────────

  /** Take in points, and let the server send more. */
  segment(segment: Segment): void {
    const mine = segment.sequence === this.info?.id;
    const used = mine && this.store.add(segment);
    this.counters.applied += 1;
    this.counters.points += segment.count;
    this.counters.bytes += segment.nbytes;
    this.counters.decodeMs += segment.decodeMs;
    if (!used) this.counters.dropped += 1;
    this.link.post({ t: 'applied', pace: this.pace() });
    if (used) this.trim();
    else this.link.recycle(buffersOf(segment));
    const frame = this.store.get(segment.frame);
    if (used && frame?.complete) this.completed.run(frame);
    if (!peek(state.playing) && segment.frame === peek(state.frame)) this.sync();
  }

  /** Ask for the whole of a paused frame, however many of its points are drawn. */
  private pace(): Pace {
    return { points: peek(state.playing) ? this.pointBudget : null };
  }

  labels(update: LabelUpdate): void {
    this.store.applyLabels(update);
    this.viewer.invalidate();
  }

  private trim(): void {
    const head = { frame: peek(state.frame), direction: this.clock.direction };
    const keep = [this.shown?.index ?? -1, ...this.around(head.frame)];
    const dropped = this.store.evict(head, keep);
    if (dropped.length === 0) return;
    this.link.send({ type: 'forget', frames: dropped.map((frame) => frame.index) });
    for (const frame of dropped) this.link.recycle(frame.release());
  }

  /** Drop chunks of a large frame. */
  dropChunks(frame: CloudFrame, chunks: readonly number[]): void {
    this.link.recycle(this.store.dropChunks(frame, chunks));
  }

  /** Drop frames from the cache and notify the server. */
  forget(frames: readonly CloudFrame[]): void {
    this.link.send({ type: 'forget', frames: frames.map((frame) => frame.index) });
    for (const frame of frames) {
      this.store.drop(frame);
      this.link.recycle(frame.release());
    }
  }

  // ── before each picture ────────────────────────────────────────────────────────────────────

  update(now: number): void {
    if (peek(state.playing)) this.advance(now);
    this.sync();
    this.report(now);
  }

  private advance(now: number): void {
    if (this.clock.ended(now)) {
      this.pause(this.clock.frameAt(now));
      return;
    }
    const frame = looped(this.clock.frameAt(now), this.clock.direction);
    if (frame === peek(state.frame)) return;
    const back = frame !== this.clock.frameAt(now);
    state.frame.value = frame;
    if (back) this.restart();
  }

  /** Put the newest frame that is here on screen, and the next one on the GPU. */
  private sync(): void {
    if (!this.info) return;
    const { store, clock } = this;
    const playing = peek(state.playing);
    const head = peek(state.frame);
    // The server sends nothing of a frame without points.
    const empty = this.info.points[head] === 0;
    const coming = playing && !empty;
    const index = coming ? store.newest(head, clock.direction, peek(state.loop)) : head;
    const frame = empty ? store.nothing(head) : store.get(index);
    if (!frame || (frame.loaded === 0 && !frame.empty)) return;
    if (!this.show(frame) && playing) this.prepare(index + clock.direction);
  }

  /** The picture stands: time to bring the next frame over. */
  private prepare(index: number): void {
    const { length } = this.store;
    const next = this.store.get((index + length) % length);
    if (next && next.loaded > 0) this.viewer.prepare(next);
  }

  /** Put a frame on screen; false when it is there as it is. */
  private show(frame: CloudFrame): boolean {
    const { pointsVersion, labelsVersion } = frame;
    const same = pointsVersion === this.shownVersion && labelsVersion === this.shownLabels;
    if (frame === this.shown && same) return false;
    this.shown = frame;
    this.shownVersion = pointsVersion;
    this.shownLabels = labelsVersion;
    this.viewer.show(frame);
    state.shown.value = frame.shown;
    return true;
  }

  /** The buffer bar, a few times a second at most. */
  private report(now: number): void {
    if (this.store.version === this.rangesVersion) return;
    if (now - this.ranges < 200) return;
    this.ranges = now;
    this.rangesVersion = this.store.version;
    state.loaded.value = this.store.ranges();
  }
}
