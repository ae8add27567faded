/** A recording's lattice, and WebAssembly that decodes its bands in memory that all frames share. */
import type { Lattice } from '../../protocol/messages';
import {
  ENTRIES,
  lowBytes,
  TOKEN_VALUES,
  tokenBytes,
  writeEntries,
  type Numbers,
  type Parts,
} from './codec';
import { inOneMemory, instantiate, type Decode } from './kernel';
import { bandsOf, firstStep, pixelsOf, type Band } from './lattice';

/** State of a frame's earlier chunks that its later chunks need. */
export interface Known {
  /** Distance between the received pixels, and their values, row by row. */
  readonly step: number;
  readonly pixels: Uint16Array;
}

export class Camera {
  readonly bands: readonly Band[];
  private readonly stride: number;
  private readonly arrays: ReturnType<typeof arraysOf>;
  private readonly kernel: Decode;

  constructor(readonly lattice: Lattice) {
    this.bands = bandsOf(lattice);
    this.stride = lattice.width + firstStep(lattice);
    const { memory, views } = inOneMemory(arraysOf(lattice, this.bands));
    this.arrays = views;
    this.kernel = instantiate(memory);
  }

  /** Write the depths of all pixels, row by row. */
  read(listed: Uint16Array, out: Uint16Array): void {
    const { width, height } = this.lattice;
    const { image } = this.arrays;
    for (let row = 0; row < height; row++) {
      const start = row * this.stride;
      out.set(image.subarray(start, start + width), row * width);
    }
    if (listed.length === 0) return;
    for (let i = 0; i < out.length; i++) out[i] = out[i] === 0 ? 0 : listed[out[i]! - 1]!;
  }

  /** Begin with the earlier pixels of a frame, or with none. */
  restore(known: Known | null): void {
    const { image } = this.arrays;
    image.fill(0);
    if (known) this.visit(known.step, (place, i) => (image[place] = known.pixels[i]!));
  }

  /** The values of pixels `step` apart. */
  save(step: number): Known {
    const { width, height } = this.lattice;
    const { image } = this.arrays;
    const pixels = new Uint16Array(Math.ceil(width / step) * Math.ceil(height / step));
    this.visit(step, (place, i) => (pixels[i] = image[place]!));
    return { step, pixels };
  }

  /** Call `each` with the places in the image of pixels `step` apart, in turn. */
  private visit(step: number, each: (place: number, turn: number) => void): void {
    const { width, height } = this.lattice;
    for (let row = 0, i = 0; row < height; row += step) {
      for (let column = 0; column < width; column += step, i++) {
        each(row * this.stride + column, i);
      }
    }
  }

  /** Decode a chunk, of which `numbers` are the tables.  Returns the number of its points. */
  decode(chunk: number, numbers: Numbers, { tokens, low }: Parts): number {
    const band = this.bands[chunk];
    if (!band) throw new RangeError(`depth: expected chunks before ${this.bands.length}`);
    const { arrays, stride } = this;
    writeEntries(arrays.entries, numbers);
    fill(arrays.tokens, tokens);
    fill(arrays.low, low);
    const { width } = this.lattice;
    const { row, stop, column, down, across, half, vertical } = band;
    const count = this.kernel(
      ...[arrays.image.byteOffset, stride],
      ...[row, stop, column, width, down, across, half, Number(vertical)],
      ...[arrays.entries.byteOffset, arrays.tokenValues.byteOffset],
      ...[arrays.tokens.byteOffset, arrays.tokens.byteOffset + tokens.length],
      ...[arrays.low.byteOffset, 8 * low.length],
    );
    if (count < 0) throw new RangeError('depth: expected more bytes, got their end');
    return count;
  }
}

/** Layout of the memory as it is at first. */
function arraysOf(lattice: Lattice, bands: readonly Band[]) {
  const { width, height } = lattice;
  // The margin holds neighbours beyond the edges.
  const margin = firstStep(lattice);
  const most = Math.max(...bands.map((band) => pixelsOf(band, width)));
  return {
    image: new Uint16Array((width + margin) * (height + margin)),
    entries: new Uint32Array(ENTRIES),
    tokenValues: TOKEN_VALUES,
    tokens: new Uint8Array(tokenBytes(most)),
    low: new Uint8Array(lowBytes(most)),
  };
}

/** Copy to the start of a part of the memory. */
function fill(target: Uint8Array, source: Uint8Array): void {
  if (source.length > target.length) {
    throw new RangeError(`depth: expected ${target.length} bytes at most, got ${source.length}`);
  }
  target.set(source);
}
