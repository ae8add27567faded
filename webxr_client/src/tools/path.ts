/** Samples of a pointing device, and the path of a stroke that they make. */
import type { Sample } from '../protocol/messages';
import type { PointerSample, Vec } from '../store/types';

/** A sample in the source's coordinates. */
export function sourceSample({ origin, direction }: PointerSample, shift: Vec): Sample {
  return {
    origin: [origin[0] + shift[0], origin[1] + shift[1], origin[2] + shift[2]],
    direction: [...direction],
  };
}

/** Places that are kept; a longer stroke keeps every second one, and so on. */
const MOST = 256;
const NUMBERS = 6;

/** A stroke's path, so that it can be completed to an object; adding allocates nothing. */
export class Path {
  private readonly numbers = new Float64Array(MOST * NUMBERS);
  private count = 0;
  /** Of so many places one is kept. */
  private step = 1;
  private skipped = 0;

  clear(): void {
    this.count = 0;
    this.step = 1;
    this.skipped = 0;
  }

  /** The sample may be used again: it is copied.  `back`: metres that its ray begins earlier. */
  add({ origin, direction }: PointerSample, back = 0): void {
    this.skipped += 1;
    if (this.count > 0 && this.skipped < this.step) return;
    this.skipped = 0;
    if (this.count === MOST) this.thin();
    const at = this.count * NUMBERS;
    for (let k = 0; k < 3; k++) {
      this.numbers[at + k] = origin[k]! - back * direction[k]!;
      this.numbers[at + 3 + k] = direction[k]!;
    }
    this.count += 1;
  }

  private thin(): void {
    for (let i = 1; 2 * i < this.count; i++) {
      this.numbers.copyWithin(i * NUMBERS, 2 * i * NUMBERS, (2 * i + 1) * NUMBERS);
    }
    this.count = MOST / 2;
    this.step *= 2;
  }

  samples(): PointerSample[] {
    return Array.from({ length: this.count }, (_, i) => {
      const [x, y, z, a, b, c] = this.numbers.subarray(i * NUMBERS, (i + 1) * NUMBERS);
      return { origin: [x!, y!, z!], direction: [a!, b!, c!] };
    });
  }
}
