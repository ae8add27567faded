/** Times of the last frames, for the rate control, the headset's budget and the benchmarks. */

const LENGTH = 256;

export class Timing {
  private readonly values = new Float32Array(LENGTH);
  private count = 0;
  /** A running mean over about 20 values. */
  mean = 0;

  add(ms: number): void {
    this.values[this.count % LENGTH] = ms;
    this.count += 1;
    this.mean = this.count === 1 ? ms : this.mean + (ms - this.mean) / 20;
  }

  /** The newest value. */
  get last(): number {
    return this.values[(this.count + LENGTH - 1) % LENGTH]!;
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
    this.mean = 0;
  }
}
