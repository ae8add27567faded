/** The page's cache of frames, kept under a budget of bytes. */
import type { Segment } from '../../net/chunk/segment';
import type { LabelUpdate } from '../../net/wire';
import type { LoadedRange } from '../../store/state';
import { CloudFrame } from './frame';

export interface Playhead {
  readonly frame: number;
  /** 1 forward, −1 backward. */
  readonly direction: number;
}

export class FrameStore {
  private readonly frames = new Map<number, CloudFrame>();
  private bytes = 0;
  /** Counts changes of the loaded points, for the buffer bar. */
  version = 0;

  constructor(
    readonly length: number,
    readonly large: boolean,
    readonly budget: number,
  ) {}

  get(index: number): CloudFrame | undefined {
    return this.frames.get(index);
  }

  /** A frame with something to show. */
  has(index: number): boolean {
    return (this.frames.get(index)?.loaded ?? 0) > 0;
  }

  get size(): number {
    return this.frames.size;
  }

  get usedBytes(): number {
    return this.bytes;
  }

  all(): IterableIterator<CloudFrame> {
    return this.frames.values();
  }

  /** Take in points; return false if they do not continue the loaded ones. */
  add(segment: Segment): boolean {
    const frame = this.ensure(segment.frame);
    const before = frame.bytes;
    const used = frame.add(segment);
    this.bytes += frame.bytes - before;
    this.version += 1;
    return used;
  }

  /** A frame that has no points. */
  nothing(index: number): CloudFrame {
    const frame = this.ensure(index);
    frame.complete = true;
    return frame;
  }

  applyLabels(update: LabelUpdate): void {
    // A delta to a frame that is not here needs no keeping: its points bring whole labels.
    const frame = update.base === null ? this.ensure(update.frame) : this.frames.get(update.frame);
    frame?.applyLabels(update);
  }

  private ensure(index: number): CloudFrame {
    let frame = this.frames.get(index);
    if (!frame) this.frames.set(index, (frame = new CloudFrame(index, this.large)));
    return frame;
  }

  /**
   * Drop frames until the budget holds, the last ones in the order of playback first; never the
   * playhead's own frame or the frames to keep.
   */
  evict(playhead: Playhead, keep: readonly number[]): CloudFrame[] {
    if (this.bytes <= this.budget) return [];
    const wait = (index: number): number =>
      ((index - playhead.frame) * playhead.direction + this.length) % this.length;
    const order = [...this.frames.values()]
      .filter((frame) => frame.index !== playhead.frame && !keep.includes(frame.index))
      .sort((a, b) => wait(b.index) - wait(a.index));
    const dropped: CloudFrame[] = [];
    for (const frame of order) {
      if (this.bytes <= this.budget) break;
      this.drop(frame);
      dropped.push(frame);
    }
    return dropped;
  }

  /** Drop chunks of a large frame; returns the buffers that are free again. */
  dropChunks(frame: CloudFrame, chunks: readonly number[]): ArrayBuffer[] {
    const before = frame.bytes;
    const buffers = chunks.map((chunk) => frame.remove(chunk)).filter((buffer) => buffer !== null);
    this.bytes += frame.bytes - before;
    this.version += 1;
    return buffers;
  }

  drop(frame: CloudFrame): void {
    this.frames.delete(frame.index);
    this.bytes -= frame.bytes;
    this.version += 1;
  }

  /** Newest frame here at or before the clock in the direction of play; −1 when none is. */
  newest(head: number, direction: number, loop: boolean): number {
    for (let back = 0; back < this.length; back++) {
      let index = head - back * direction;
      if (index < 0 || index >= this.length) {
        if (!loop) return -1;
        index = ((index % this.length) + this.length) % this.length;
      }
      if (this.has(index)) return index;
    }
    return -1;
  }

  /** Runs of frames that are here, for the buffer bar. */
  ranges(): LoadedRange[] {
    const ranges: { first: number; last: number; complete: boolean }[] = [];
    const indices = [...this.frames.keys()]
      .filter((index) => this.has(index))
      .sort((a, b) => a - b);
    for (const index of indices) {
      const complete = this.frames.get(index)!.complete;
      const open = ranges.at(-1);
      if (open?.last === index - 1 && open.complete === complete) open.last = index;
      else ranges.push({ first: index, last: index, complete });
    }
    return ranges;
  }
}
