/** A depth message → the depth image so far. */
import type { Depth, SequenceInfo } from '../../protocol/messages';
import type { BufferPool } from '../chunk/pool';
import type { Colours, DepthImage, Segment, SegmentChunk } from '../chunk/segment';
import { Camera, type Known } from './camera';
import { Numbers, partsOf, readListed, type Parts } from './codec';
import { gridOf, type Grid } from './grid';
import type { Picture, ReadPicture } from './pictures';

/** State of a frame's earlier chunks that its later chunks need. */
interface Begun {
  /** Chunks that came. */
  readonly chunks: number;
  readonly known: Known;
  readonly listed: Uint16Array;
}

/** A message with a picture that is read while earlier messages are decoded. */
export interface Coming {
  readonly message: Depth;
  readonly parts: readonly Parts[];
  readonly picture: Promise<Picture> | null;
}

export class DepthDecoder {
  private camera: Camera | null = null;
  private grid: Grid | null = null;
  private identity = '';
  private readonly begun = new Map<number, Begun>();

  constructor(
    private readonly pool: BufferPool,
    private readonly readPicture: ReadPicture,
  ) {}

  /** Set the recording of the frames that follow. */
  open(info: SequenceInfo): void {
    if (info.identity === this.identity) return;
    this.identity = info.identity;
    const { lattice, lo, hi } = info;
    this.camera = lattice && new Camera(lattice);
    this.grid = lattice && gridOf(lattice, lo, hi);
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
    const jpeg = parts[lastPicture(parts)]?.picture as Uint8Array<ArrayBuffer> | undefined;
    return { message, parts, picture: jpeg ? this.readPicture(jpeg) : null };
  }

  /**
   * The points of a message.  None if they do not continue the frame's earlier points, because the
   * frame was forgotten.
   */
  async decode(coming: Coming): Promise<Segment> {
    const { message } = coming;
    const { camera } = this;
    const first = message.chunks[0]?.index ?? 0;
    const before = first > 0 ? this.begun.get(message.frame) : undefined;
    if (!camera || message.chunks.length === 0 || (before?.chunks ?? 0) !== first) {
      void coming.picture?.then((picture) => picture.close());
      return segmentOf(message, [], null, 0);
    }
    // The browser reads the picture at the same time.
    const painted = this.paint(camera, coming, first);
    const started = performance.now();
    const { chunks, listed } = this.join(camera, coming, before);
    const done = first + chunks.length;
    if (message.final) this.begun.delete(message.frame);
    else {
      const known = camera.save(camera.bands[done - 1]!.step);
      this.begun.set(message.frame, { chunks: done, known, listed });
    }
    const { lattice } = camera;
    const size = lattice.width * lattice.height;
    const bytes = this.pool.take(size * Uint16Array.BYTES_PER_ELEMENT);
    const depths = new Uint16Array(bytes, 0, size);
    camera.read(listed, depths);
    const took = performance.now() - started;
    return segmentOf(message, chunks, { lattice, depths, colours: await painted }, took);
  }

  /** The picture of a message with chunks from `first` on. */
  private async paint(
    camera: Camera,
    { parts, picture: coming }: Coming,
    first: number,
  ): Promise<Colours | null> {
    // prettier-ignore
    if (!coming) return null;
    const { pictureStep: step } = camera.bands[first + lastPicture(parts)]!;
    const picture = await coming;
    try {
      const [width, height] = [camera.lattice.width, camera.lattice.height].map((side) => Math.ceil(side / step)); // prettier-ignore
      if (picture.width !== width || picture.height !== height) {
        throw new RangeError(
          `depth: expected a picture of ${width} by ${height} pixels, ` +
            `got ${picture.width} by ${picture.height}`,
        );
      }
      return {
        ...(await picture.read((size) => this.pool.take(size + camera.lattice.width))),
        step,
      };
    } finally {
      picture.close();
    }
  }

  /** Decode all chunks' points; returns the depths that are listed of the frame as well. */
  private join(
    camera: Camera,
    { message, parts }: Coming,
    before: Begun | undefined,
  ): { chunks: SegmentChunk[]; listed: Uint16Array } {
    const chunks: SegmentChunk[] = [];
    let listed = before?.listed ?? new Uint16Array(0);
    camera.restore(before?.known ?? null);
    message.chunks.forEach((chunk, i) => {
      const numbers = new Numbers(parts[i]!.tables);
      if (chunk.index === 0) listed = readListed(numbers);
      const count = camera.decode(chunk.index, numbers, parts[i]!);
      if (count !== chunk.count) {
        throw new RangeError(`depth: expected ${chunk.count} points, got ${count}`);
      }
      chunks.push({ ...chunk, ...this.grid!, start: 0 });
    });
    return { chunks, listed };
  }
}

function segmentOf(
  { sequence, frame, total, final, data }: Depth,
  chunks: readonly SegmentChunk[],
  image: DepthImage | null,
  decodeMs: number,
): Segment {
  const count = chunks.reduce((sum, chunk) => sum + chunk.count, 0);
  const nbytes = data.byteLength;
  const vertices = new ArrayBuffer(0);
  // Points that do not join on end nothing.
  return { sequence, frame, total, final: final && image !== null, count, chunks, vertices, image, nbytes, decodeMs }; // prettier-ignore
}

/** Number of the last chunk with a picture, the finest; −1 without one. */
function lastPicture(parts: readonly Parts[]): number {
  return parts.findLastIndex(({ picture }) => picture.length > 0);
}
