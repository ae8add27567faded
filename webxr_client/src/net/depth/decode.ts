/** A depth message → vertices, as `decodeFrame` makes them of a frame message. */
import type { Depth, SequenceInfo } from '../../protocol/messages';
import type { BufferPool } from '../chunk/pool';
import { STRIDE, type Segment, type SegmentChunk } from '../chunk/segment';
import { Camera, type Known } from './camera';
import { Numbers, partsOf, readListed, type Parts } from './codec';
import { gridOf } from './grid';
import type { Picture, ReadPicture } from './pictures';

/** State of a frame that its later chunks need of those before them. */
interface Begun {
  /** Chunks that came. */
  readonly chunks: number;
  readonly known: Known;
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
    const { jpeg, step: pictureStep } = pictureOf(camera, parts, before, first);
    const picture = await (coming ?? (jpeg && this.readPicture(jpeg)));
    if (picture) await camera.paint(picture, pictureStep);
    const waited = performance.now();

    const colorStep = picture ? pictureStep : 0;
    const { vertices, chunks, listed } = this.join(camera, message, parts, before, colorStep);
    const done = first + chunks.length;
    if (message.final) this.begun.delete(message.frame);
    else {
      const known = camera.save(camera.bands[done - 1]!.step);
      const kept = { chunks: done, known, listed, jpeg: jpeg?.slice() ?? null, pictureStep };
      this.begun.set(message.frame, kept);
    }
    const decodeMs = performance.now() - waited + (picture ? 0 : waited - began);
    return this.segment(message, chunks, vertices, decodeMs, message.final);
  }

  /** The points of all chunks, and the pixels that are listed of the frame. */
  private join(
    camera: Camera,
    message: Depth,
    parts: readonly Parts[],
    before: Begun | undefined,
    colorStep: number,
  ): { vertices: ArrayBuffer; chunks: SegmentChunk[]; listed: Uint16Array } {
    const points = message.chunks.reduce((sum, chunk) => sum + chunk.count, 0);
    const vertices = this.pool.take(points * STRIDE);
    const bytes = new Uint8Array(vertices);
    const chunks: SegmentChunk[] = [];
    camera.restore(before?.known ?? null);
    let listed = before?.listed ?? new Uint16Array(0);
    let start = 0;
    message.chunks.forEach((chunk, i) => {
      const numbers = new Numbers(parts[i]!.tables);
      if (chunk.index === 0) listed = readListed(numbers);
      const decoded = camera.decode(chunk.index, numbers, parts[i]!, listed, colorStep);
      const count = decoded.length / STRIDE;
      if (count !== chunk.count) {
        throw new RangeError(`depth: expected ${chunk.count} points, got ${count}`);
      }
      bytes.set(decoded, start * STRIDE);
      chunks.push({ ...chunk, ...camera.grid, start });
      start += count;
    });
    return { vertices, chunks, listed };
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

/** The finest picture that came of a frame, whose chunks of this message begin at `first`. */
function pictureOf(
  camera: Camera,
  parts: readonly Parts[],
  before: Begun | undefined,
  first: number,
): { jpeg: Uint8Array<ArrayBuffer> | null; step: number } {
  const jpeg = finest(parts);
  if (jpeg) return { jpeg, step: camera.bands[first + lastPicture(parts)]!.pictureStep };
  return { jpeg: before?.jpeg ?? null, step: before?.pictureStep ?? 1 };
}

function lastPicture(parts: readonly Parts[]): number {
  return parts.findLastIndex(({ picture }) => picture.length > 0);
}

function finest(parts: readonly Parts[]): Uint8Array<ArrayBuffer> | null {
  return (parts[lastPicture(parts)]?.picture as Uint8Array<ArrayBuffer> | undefined) ?? null;
}
