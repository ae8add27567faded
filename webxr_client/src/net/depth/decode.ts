/** A depth message → the depth images so far. */
import type { Chunk, Depth, DepthChunk, SequenceInfo } from '../../protocol/messages';
import { decodeChunks } from '../chunk/decode';
import { boxGrid, eyeOf, mountOf } from '../chunk/grid';
import type { BufferPool } from '../chunk/pool';
import type { Colours, DepthImage, Segment, SegmentChunk } from '../chunk/segment';
import { Camera, type Known } from './camera';
import { Numbers, partsOf, readListed, type Parts } from './codec';
import { gridOf } from './grid';
import type { Picture, ReadPicture } from './pictures';

/** State of the earlier chunks of a camera's image that its later chunks need. */
interface Begun {
  /** Chunks that came, and the number of the last one in the frame. */
  readonly chunks: number;
  readonly last: number;
  readonly known: Known;
  readonly listed: Uint16Array;
}

/** One camera's chunks in a message, with a picture that is read while earlier messages are decoded. */
interface Run {
  readonly sensor: number;
  readonly chunks: readonly DepthChunk[];
  readonly parts: readonly Parts[];
  readonly picture: Promise<Picture> | null;
}

export interface Coming {
  readonly message: Depth;
  readonly runs: readonly Run[];
  /** Chunks of sensors that are no depth cameras. */
  readonly points: readonly Chunk[];
}

export class DepthDecoder {
  private info: SequenceInfo | null = null;
  /** By sensor; null: it is no depth camera. */
  private cameras: readonly (Camera | null)[] = [];
  /** By frame and sensor. */
  private readonly begun = new Map<number, Map<number, Begun>>();

  constructor(
    private readonly pool: BufferPool,
    private readonly readPicture: ReadPicture,
  ) {}

  /** Set the recording of the frames that follow. */
  open(info: SequenceInfo): void {
    const before = this.info;
    this.info = info;
    if (info.identity === before?.identity) return;
    const { lattice, sensors } = info;
    const lattices = sensors.length > 0 ? sensors.map((sensor) => sensor.lattice) : [lattice];
    this.cameras = lattices.map((each) => each && new Camera(each));
    this.begun.clear();
  }

  /** The page dropped these frames: if they come again, they come from the start. */
  forget(frames: readonly number[]): void {
    for (const frame of frames) this.begun.delete(frame);
  }

  /** Take a message apart and have the finest picture of each camera read. */
  receive(message: Depth): Coming {
    const points = message.chunks.filter(isPoints);
    const bands = message.chunks.filter((chunk) => !isPoints(chunk));
    const sensors = [...new Set(bands.map(({ sensor }) => sensor ?? 0))];
    const runs = sensors.map((sensor) => {
      const chunks = bands.filter((chunk) => (chunk.sensor ?? 0) === sensor);
      const parts = chunks.map(({ offset, nbytes }) =>
        partsOf(message.data.subarray(offset, offset + nbytes)),
      );
      const jpeg = parts[lastPicture(parts)]?.picture as Uint8Array<ArrayBuffer> | undefined;
      return { sensor, chunks, parts, picture: jpeg ? this.readPicture(jpeg) : null };
    });
    return { message, runs, points };
  }

  /**
   * The points of a message.  None if they do not continue the frame's earlier points, because the
   * frame was forgotten.
   */
  async decode({ message, runs, points }: Coming): Promise<Segment> {
    const started = performance.now();
    const begun = this.begun.get(message.frame) ?? new Map<number, Begun>();
    if (!runs.every((run) => this.joins(run, begun.get(run.sensor)))) {
      for (const { picture } of runs) void picture?.then((read) => read.close());
      return segmentOf(message, [], [], new ArrayBuffer(0), 0);
    }
    const { chunks, vertices } = decodeChunks(points, message, this.info!, this.pool);
    const images: DepthImage[] = [];
    let took = performance.now() - started;
    for (const run of runs) {
      const decoded = await this.decodeRun(message, run, begun);
      chunks.push(...decoded.chunks);
      images.push(decoded.image);
      took += decoded.took;
    }
    if (message.final) this.begun.delete(message.frame);
    else this.begun.set(message.frame, begun);
    chunks.sort((a, b) => a.index - b.index);
    return segmentOf(message, chunks, images, vertices, took);
  }

  /** Whether a camera's chunks begin its image or continue it. */
  private joins({ sensor, chunks: [first] }: Run, begun: Begun | undefined): boolean {
    const bands = this.cameras[sensor]?.bands;
    if (!bands || first!.level === 0) return bands !== undefined;
    return begun !== undefined && first!.index > begun.last && bands[begun.chunks]?.level === first!.level; // prettier-ignore
  }

  /** Decode the chunks of one camera, and keep what its later chunks need in `begun`. */
  private async decodeRun(
    { frame, final }: Depth,
    run: Run,
    begun: Map<number, Begun>,
  ): Promise<{ chunks: SegmentChunk[]; image: DepthImage; took: number }> {
    const { sensor } = run;
    const camera = this.cameras[sensor]!;
    const { lattice } = camera;
    const mount = mountOf(this.info!, sensor, frame);
    const before = run.chunks[0]!.level > 0 ? begun.get(sensor) : undefined;
    // The browser reads the picture at the same time.
    const painted = this.paint(camera, run, before?.chunks ?? 0);
    const started = performance.now();
    const listed = this.join(camera, run, before);
    const grid = gridOf({ lattice, mount }, boxGrid(this.info!.lo, this.info!.hi));
    const own = { ...grid, sensor, eye: eyeOf(mount), start: 0 };
    const chunks = run.chunks.map((chunk) => ({ ...chunk, ...own }));
    const done = (before?.chunks ?? 0) + chunks.length;
    if (!final) {
      const known = camera.save(camera.bands[done - 1]!.step);
      begun.set(sensor, { chunks: done, last: chunks.at(-1)!.index, known, listed });
    }
    const size = lattice.width * lattice.height;
    const bytes = this.pool.take(size * Uint16Array.BYTES_PER_ELEMENT);
    const depths = new Uint16Array(bytes, 0, size);
    camera.read(listed, depths);
    const took = performance.now() - started;
    return { chunks, took, image: { sensor, lattice, mount, depths, colours: await painted } };
  }

  /** The picture of a camera's chunks from its `first` on. */
  private async paint(
    camera: Camera,
    { parts, picture: coming }: Run,
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
  private join(camera: Camera, { chunks, parts }: Run, before: Begun | undefined): Uint16Array {
    const first = before?.chunks ?? 0;
    let listed = before?.listed ?? new Uint16Array(0);
    camera.restore(before?.known ?? null);
    chunks.forEach((chunk, i) => {
      const numbers = new Numbers(parts[i]!.tables);
      if (first + i === 0) listed = readListed(numbers);
      const count = camera.decode(first + i, numbers, parts[i]!);
      if (count !== chunk.count) {
        throw new RangeError(`depth: expected ${chunk.count} points, got ${count}`);
      }
    });
    return listed;
  }
}

function segmentOf(
  { sequence, frame, total, final, data }: Depth,
  chunks: readonly SegmentChunk[],
  images: readonly DepthImage[],
  vertices: ArrayBuffer,
  decodeMs: number,
): Segment {
  const count = chunks.reduce((sum, chunk) => sum + chunk.count, 0);
  const nbytes = data.byteLength;
  // Points that do not join on end nothing.
  return { sequence, frame, total, final: final && chunks.length > 0, count, chunks, vertices, images, nbytes, decodeMs }; // prettier-ignore
}

function isPoints(chunk: DepthChunk): chunk is DepthChunk & Chunk {
  return Boolean(chunk.origin);
}

/** Number of the last chunk with a picture, the finest; −1 without one. */
function lastPicture(parts: readonly Parts[]): number {
  return parts.findLastIndex(({ picture }) => picture.length > 0);
}
