/** Array buffers that go round: the worker fills them, the page shows and returns them. */

const GRAIN = 1 << 16;

export class BufferPool {
  private readonly free: ArrayBuffer[] = [];
  private bytes = 0;

  constructor(private readonly limit: number) {}

  /** A buffer of at least `size` bytes; its contents are arbitrary. */
  take(size: number): ArrayBuffer {
    const { free } = this;
    let best = -1;
    // The smallest that fits: a larger one is the only one for the parts of a frame that need it.
    for (let i = free.length - 1; i >= 0; i--) {
      const bytes = free[i]!.byteLength;
      if (bytes < size || bytes > 2 * size + GRAIN) continue;
      if (best < 0 || bytes < free[best]!.byteLength) best = i;
    }
    if (best < 0) return new ArrayBuffer(Math.max(GRAIN, Math.ceil(size / GRAIN) * GRAIN));
    const buffer = free[best]!;
    free[best] = free[free.length - 1]!;
    free.pop();
    this.bytes -= buffer.byteLength;
    return buffer;
  }

  give(buffer: ArrayBuffer): void {
    if (buffer.byteLength === 0 || this.bytes + buffer.byteLength > this.limit) return;
    this.free.push(buffer);
    this.bytes += buffer.byteLength;
  }
}
