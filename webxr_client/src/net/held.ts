/** Record of the sent parts of each frame, so that a new connection need not send them again. */
import type { Annotation, Depth, Frame } from '../protocol/messages';

interface HeldFrame {
  /** Chunks from the first on. */
  chunks: number;
  /** The newest revision that the frame's labels include. */
  revision: number;
}

export class HeldFrames {
  private readonly frames = new Map<number, HeldFrame>();

  clear(): void {
    this.frames.clear();
  }

  forget(frames: readonly number[]): void {
    for (const frame of frames) this.frames.delete(frame);
  }

  /** The server answered `open`: all changes up to this revision are on their way. */
  resumed(revision: number): void {
    for (const held of this.frames.values()) held.revision = Math.max(held.revision, revision);
  }

  points(message: Frame | Depth): void {
    const held = this.frames.get(message.frame);
    // Deltas that do not join on are left out by the page as well.
    if (held && message.chunks[0]?.index === held.chunks) held.chunks += message.chunks.length;
  }

  /** Take note of values; false when they build on a revision that never came. */
  values(message: Annotation): boolean {
    const held = this.frames.get(message.frame);
    if (message.base === null) {
      if (held) held.revision = Math.max(held.revision, message.revision);
      else this.frames.set(message.frame, { chunks: 0, revision: message.revision });
      return true;
    }
    if (!held) return true;
    if (message.base > held.revision) return false;
    held.revision = Math.max(held.revision, message.revision);
    return true;
  }

  /** For `open`: frames with something to show, and how much of them is here. */
  list(): [number, number][] {
    return [...this.frames]
      .filter(([, held]) => held.chunks > 0)
      .map(([frame, held]) => [frame, held.chunks]);
  }
}
