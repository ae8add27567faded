/** Times of the last pictures, for the budget of points and the benchmarks. */

const LENGTH = 256;

export class Timing {
  private readonly values = new Float32Array(LENGTH);
  private count = 0;
  /** Time of the last mark; −1 if there is none to measure from. */
  private readonly marked = Float64Array.of(-1);

  add(ms: number): void {
    this.values[this.count % LENGTH] = ms;
    this.count += 1;
  }

  /** Add the time since the last mark. */
  mark(now: number): void {
    const { marked } = this;
    if (marked[0]! >= 0) {
      this.values[this.count % LENGTH] = now - marked[0]!;
      this.count += 1;
    }
    marked[0] = now;
  }

  /** Begin anew: the next mark has nothing to do with the one before. */
  interrupt(): void {
    this.marked[0] = -1;
  }

  /** Write the newest value: a number that is given back would be boxed. */
  last(out: Float64Array): void {
    out[0] = this.values[(this.count + LENGTH - 1) % LENGTH]!;
  }

  get total(): number {
    return this.count;
  }

  /** The last values (at most 256), oldest first. */
  recent(): number[] {
    const n = Math.min(this.count, LENGTH);
    return Array.from({ length: n }, (_, i) => this.values[(this.count - n + i) % LENGTH]!);
  }

  reset(): void {
    this.count = 0;
  }
}
