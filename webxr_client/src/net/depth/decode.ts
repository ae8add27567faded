/** A depth message → vertices, as `decodeFrame` makes them of a frame message. */
import type { Depth, Lattice, SequenceInfo } from '../../protocol/messages';
import type { BufferPool } from '../pool';
import { STRIDE, type Segment, type SegmentChunk } from '../segment';
import { BandPlan, gridOf, type Colors, type Grid } from './band';
import { Numbers, partsOf, readListed, Streams, Tables, type Parts } from './codec';
import { bandsOf, firstStep, type Band } from './lattice';
import { PIXEL_BYTES, type Picture, type ReadPicture } from './pictures';

/** State of a frame that its later chunks need of those before them. */
interface Begun {
  /** Chunks that came. */
  readonly chunks: number;
  /** Distance between the pixels that came, and what these hold, row by row. */
  readonly step: number;
  readonly pixels: Uint16Array;
  readonly listed: Uint16Array;
  /** The finest picture, in JPEG. */
  readonly jpeg: Uint8Array<ArrayBuffer> | null;
  readonly pictureStep: number;
}

/** A message whose picture is being read while those before it are decoded. */
export interface Coming {
  readonly message: Depth;
  readonly parts: readonly Parts[];
  readonly picture: Promise<Picture> | null;
}

export class DepthDecoder {
  private camera: Camera | null = null;
  private identity = '';
  private readonly begun = new Map<number, Begun>();

  constructor(
    private readonly pool: BufferPool,
    private readonly readPicture: ReadPicture,
  ) {}

  /** The recording whose frames come from here on. */
  open(info: SequenceInfo): void {
    if (info.identity === this.identity) return;
    this.identity = info.identity;
    this.camera = info.lattice && new Camera(info.lattice, gridOf(info.lattice, info.lo, info.hi));
    this.begun.clear();
  }

  /** The page dropped these frames: if they come again, they come from the start. */
  forget(frames: readonly number[]): void {
    for (const frame of frames) this.begun.delete(frame);
  }

  /** Take a message apart and have its finest picture read. */
  receive(message: Depth): Coming {
    const parts = message.chunks.map(({ offset, nbytes }) =>
      partsOf(message.data.subarray(offset, offset + nbytes)),
    );
    const jpeg = finest(parts);
    return { message, parts, picture: jpeg && this.readPicture(jpeg) };
  }

  /**
   * The points of a message.  None where they do not join on to what came of the frame: it has been
   * forgotten meanwhile.
   */
  async decode({ message, parts, picture: coming }: Coming): Promise<Segment> {
    const began = performance.now();
    const { camera } = this;
    const first = message.chunks[0]?.index ?? 0;
    const before = first > 0 ? this.begun.get(message.frame) : undefined;
    if (!camera || message.chunks.length === 0 || (before?.chunks ?? 0) !== first) {
      void coming?.then((picture) => picture.close());
      return this.segment(message, [], this.pool.take(0), 0, false);
    }
    const at = first + lastPicture(parts);
    const jpeg = finest(parts) ?? before?.jpeg ?? null;
    const pictureStep = finest(parts) ? camera.bands[at]!.pictureStep : (before?.pictureStep ?? 1);
    const picture = await (coming ?? (jpeg && this.readPicture(jpeg)));
    const colors = picture && (await camera.colorsOf(picture, pictureStep));
    const waited = performance.now();

    const points = message.chunks.reduce((sum, chunk) => sum + chunk.count, 0);
    const vertices = this.pool.take(points * STRIDE);
    const chunks: SegmentChunk[] = [];
    camera.restore(before ?? null);
    let listed = before?.listed ?? new Uint16Array(0);
    let start = 0;
    message.chunks.forEach((chunk, i) => {
      const numbers = new Numbers(parts[i]!.tables);
      if (chunk.index === 0) listed = readListed(numbers);
      const words = new Uint32Array(vertices, start * STRIDE, (chunk.count * STRIDE) / 4);
      const count = camera.decode(chunk.index, numbers, parts[i]!, listed, colors, words);
      if (count !== chunk.count) {
        throw new RangeError(`depth: expected ${chunk.count} points, got ${count}`);
      }
      chunks.push({ ...chunk, ...camera.grid, start });
      start += count;
    });
    const done = first + chunks.length;
    if (message.final) this.begun.delete(message.frame);
    else {
      const step = camera.bands[done - 1]!.step;
      const kept = { chunks: done, step, listed, jpeg: jpeg?.slice() ?? null, pictureStep };
      this.begun.set(message.frame, { ...kept, pixels: camera.save(step) });
    }
    const decodeMs = performance.now() - waited + (picture ? 0 : waited - began);
    return this.segment(message, chunks, vertices, decodeMs, message.final);
  }

  private segment(
    { sequence, frame, total, data }: Depth,
    chunks: readonly SegmentChunk[],
    vertices: ArrayBuffer,
    decodeMs: number,
    final: boolean,
  ): Segment {
    const count = chunks.reduce((sum, chunk) => sum + chunk.count, 0);
    const nbytes = data.byteLength;
    return { sequence, frame, total, final, count, chunks, vertices, nbytes, decodeMs };
  }
}

function lastPicture(parts: readonly Parts[]): number {
  return parts.findLastIndex(({ picture }) => picture.length > 0);
}

function finest(parts: readonly Parts[]): Uint8Array<ArrayBuffer> | null {
  return (parts[lastPicture(parts)]?.picture as Uint8Array<ArrayBuffer> | undefined) ?? null;
}

/** A recording's lattice, with an image to decode into that all frames share. */
class Camera {
  readonly bands: readonly Band[];
  private readonly plans: readonly BandPlan[];
  private readonly tables = new Tables();
  private readonly streams = new Streams();
  private readonly stride: number;
  private readonly image: Uint16Array;
  /** Bytes of the finest picture, which all frames share. */
  private pixels = new Uint8Array(0);

  constructor(
    private readonly lattice: Lattice,
    readonly grid: Grid,
  ) {
    this.bands = bandsOf(lattice);
    this.plans = this.bands.map((band, chunk) => new BandPlan(lattice, band, chunk, grid));
    // Neighbours beyond the edges are looked for in a margin.
    const margin = firstStep(lattice);
    this.stride = lattice.width + margin;
    this.image = new Uint16Array(this.stride * (lattice.height + margin));
  }

  /** Take in the picture of pixels `step` apart, and close it. */
  async colorsOf(picture: Picture, step: number): Promise<Colors> {
    const width = Math.ceil(this.lattice.width / step);
    const height = Math.ceil(this.lattice.height / step);
    const nbytes = PIXEL_BYTES * width * height;
    if (this.pixels.length < nbytes) this.pixels = new Uint8Array(nbytes);
    const target = this.pixels.subarray(0, nbytes);
    try {
      if (picture.width !== width || picture.height !== height) {
        throw new RangeError(
          `depth: expected a picture of ${width} by ${height} pixels, ` +
            `got ${picture.width} by ${picture.height}`,
        );
      }
      await picture.copyTo(target);
    } finally {
      picture.close();
    }
    return { pixels: new Uint32Array(target.buffer, 0, width * height), width, step };
  }

  /** Begin with what came of a frame before, or with nothing. */
  restore(begun: Begun | null): void {
    this.image.fill(0);
    if (begun) this.copy(begun.step, begun.pixels, true);
  }

  /** The values of pixels `step` apart. */
  save(step: number): Uint16Array {
    const { width, height } = this.lattice;
    const pixels = new Uint16Array(Math.ceil(width / step) * Math.ceil(height / step));
    this.copy(step, pixels, false);
    return pixels;
  }

  private copy(step: number, pixels: Uint16Array, back: boolean): void {
    const { image, stride } = this;
    const { width, height } = this.lattice;
    for (let row = 0, i = 0; row < height; row += step) {
      const end = row * stride + width;
      for (let place = row * stride; place < end; place += step, i++) {
        if (back) image[place] = pixels[i]!;
        else pixels[i] = image[place]!;
      }
    }
  }

  decode(
    chunk: number,
    numbers: Numbers,
    parts: Parts,
    listed: Uint16Array,
    colors: Colors | null,
    vertices: Uint32Array,
  ): number {
    const plan = this.plans[chunk];
    if (!plan) throw new RangeError(`depth: expected chunks before ${this.plans.length}`);
    const { image, stride, tables, streams } = this;
    tables.read(numbers);
    streams.take(parts);
    return plan.decode(image, stride, streams, tables, listed, colors, vertices);
  }
}
