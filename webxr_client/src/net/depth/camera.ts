/** A recording's lattice, and WebAssembly that decodes its bands in memory that all frames share. */
import type { Lattice } from '../../protocol/messages';
import { STRIDE } from '../chunk/segment';
import {
  ENTRIES,
  lowBytes,
  TOKENS_TOLD,
  tokenBytes,
  writeEntries,
  type Numbers,
  type Parts,
} from './codec';
import { FARTHEST, raysOf, STAMPS, stampsOf, type Grid } from './grid';
import { inOneMemory, instantiate, type Decode } from './kernel';
import { bandsOf, firstStep, pixelsOf, type Band } from './lattice';
import { PIXEL_BYTES, type Picture } from './pictures';

/** Bytes that the kernel writes beyond the last vertex. */
const BEYOND = 4;

/** State of a frame that its later chunks need of those before them. */
export interface Known {
  /** Distance between the pixels that came, and what these hold, row by row. */
  readonly step: number;
  readonly pixels: Uint16Array;
}

export class Camera {
  readonly bands: readonly Band[];
  private readonly stride: number;
  private readonly arrays: ReturnType<typeof arraysOf>;
  private readonly kernel: Decode;

  constructor(
    private readonly lattice: Lattice,
    readonly grid: Grid,
  ) {
    this.bands = bandsOf(lattice);
    this.stride = lattice.width + firstStep(lattice);
    const { memory, views } = inOneMemory(arraysOf(lattice, grid, this.bands));
    this.arrays = views;
    this.kernel = instantiate(memory);
  }

  /** Take in the picture of pixels `step` apart, and close it. */
  async paint(picture: Picture, step: number): Promise<void> {
    const width = Math.ceil(this.lattice.width / step);
    const height = Math.ceil(this.lattice.height / step);
    try {
      if (picture.width !== width || picture.height !== height) {
        throw new RangeError(
          `depth: expected a picture of ${width} by ${height} pixels, ` +
            `got ${picture.width} by ${picture.height}`,
        );
      }
      await picture.copyTo(this.arrays.colors.subarray(0, PIXEL_BYTES * width * height));
    } finally {
      picture.close();
    }
  }

  /** Begin with what came of a frame before, or with nothing. */
  restore(known: Known | null): void {
    this.arrays.image.fill(0);
    if (known) this.copy(known, true);
  }

  /** The values of pixels `step` apart. */
  save(step: number): Known {
    const { width, height } = this.lattice;
    const pixels = new Uint16Array(Math.ceil(width / step) * Math.ceil(height / step));
    this.copy({ step, pixels }, false);
    return { step, pixels };
  }

  private copy({ step, pixels }: Known, back: boolean): void {
    const { stride } = this;
    const { image } = this.arrays;
    const { width, height } = this.lattice;
    for (let row = 0, i = 0; row < height; row += step) {
      const end = row * stride + width;
      for (let place = row * stride; place < end; place += step, i++) {
        if (back) image[place] = pixels[i]!;
        else pixels[i] = image[place]!;
      }
    }
  }

  /**
   * Decode a chunk, of which `numbers` are the tables.  `colorStep` of the picture that was taken
   * in, 0 without one.  Returns the vertices, until the next call.
   */
  decode(
    chunk: number,
    numbers: Numbers,
    { tokens, low }: Parts,
    listed: Uint16Array,
    colorStep: number,
  ): Uint8Array {
    const band = this.bands[chunk];
    if (!band) throw new RangeError(`depth: expected chunks before ${this.bands.length}`);
    const { arrays, stride } = this;
    writeEntries(arrays.entries, numbers);
    fill(arrays.tokens, tokens);
    fill(arrays.low, low);
    arrays.listed.set(listed);
    const { width } = this.lattice;
    const { row, stop, column, down, across, half, vertical } = band;
    const count = this.kernel(
      ...[arrays.image.byteOffset, stride, colorStep && Math.ceil(width / colorStep)],
      ...[row, stop, column, width, down, across, half, Number(vertical)],
      ...[arrays.entries.byteOffset, arrays.told.byteOffset],
      ...[arrays.tokens.byteOffset, arrays.tokens.byteOffset + tokens.length],
      ...[arrays.low.byteOffset, 8 * low.length],
      listed.length > 0 ? arrays.listed.byteOffset : 0,
      ...[arrays.colors.byteOffset, Math.log2(colorStep || 1)],
      ...[arrays.origin.byteOffset, arrays.columns.byteOffset, arrays.rows.byteOffset],
      arrays.stamps.byteOffset + chunk * STAMPS * arrays.stamps.BYTES_PER_ELEMENT,
      arrays.vertices.byteOffset,
    );
    if (count < 0) throw new RangeError('depth: expected more bytes, got their end');
    return arrays.vertices.subarray(0, STRIDE * count);
  }
}

/** Layout of the memory as it is at first. */
function arraysOf(lattice: Lattice, grid: Grid, bands: readonly Band[]) {
  const { width, height } = lattice;
  // Neighbours beyond the edges are looked for in a margin.
  const margin = firstStep(lattice);
  const most = Math.max(...bands.map((band) => pixelsOf(band, width)));
  return {
    image: new Uint16Array((width + margin) * (height + margin)),
    entries: new Uint32Array(ENTRIES),
    told: TOKENS_TOLD,
    tokens: new Uint8Array(tokenBytes(most)),
    low: new Uint8Array(lowBytes(most)),
    listed: new Uint16Array(FARTHEST),
    colors: new Uint8Array(PIXEL_BYTES * width * height),
    ...raysOf(lattice, grid),
    stamps: stampsOf(lattice, bands),
    vertices: new Uint8Array(STRIDE * most + BEYOND),
  };
}

/** Copy to the start of a part of the memory. */
function fill(target: Uint8Array, source: Uint8Array): void {
  if (source.length > target.length) {
    throw new RangeError(`depth: expected ${target.length} bytes at most, got ${source.length}`);
  }
  target.set(source);
}
