/** Array buffers that go round: the worker fills them, the page shows and returns them. */

const GRAIN = 1 << 16;

export class BufferPool {
  private readonly free: ArrayBuffer[] = [];
  private bytes = 0;

  constructor(private readonly limit: number) {}

  /** A buffer of at least `size` bytes; its contents are arbitrary. */
  take(size: number): ArrayBuffer {
    for (let i = this.free.length - 1; i >= 0; i--) {
      const buffer = this.free[i]!;
      // A buffer far too large would starve the frames that need it.
      if (buffer.byteLength >= size && buffer.byteLength <= 2 * size + GRAIN) {
        this.free[i] = this.free[this.free.length - 1]!;
        this.free.pop();
        this.bytes -= buffer.byteLength;
        return buffer;
      }
    }
    return new ArrayBuffer(Math.max(GRAIN, Math.ceil(size / GRAIN) * GRAIN));
  }

  give(buffer: ArrayBuffer): void {
    if (buffer.byteLength === 0 || this.bytes + buffer.byteLength > this.limit) return;
    this.free.push(buffer);
    this.bytes += buffer.byteLength;
  }
}
