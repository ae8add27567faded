/** A run of decoded points as the worker hands it to the page. */
import type { Lattice } from '../../protocol/messages';

export const STRIDE = 12;
/** The vertex in uint16: x, y, z; colours; stamp. */
export const WORDS = STRIDE / 2;
/** The vertex's spare 16 bits: chunk number × 64 + size code. */
export const SIZE_CODES = 64;
export const MAX_CHUNKS = 1024;

export interface SegmentChunk {
  /** Number in the frame's chunk table. */
  readonly index: number;
  readonly level: number;
  /** Stored number of the first point. */
  readonly first: number;
  readonly count: number;
  /** Number of the sensor that all points are of; 0 in a recording of one sensor. */
  readonly sensor: number;
  /** Position of one of several sensors, local metres; else the local origin. */
  readonly eye: readonly [number, number, number];
  /** Offset of the points in the segment's vertices, in points. */
  readonly start: number;
  readonly origin: readonly [number, number, number];
  readonly scale: readonly [number, number, number];
  readonly lo: readonly [number, number, number];
  readonly hi: readonly [number, number, number];
}

/** A depth camera's frame as the GPU takes it. */
export interface DepthImage {
  /** Number of the camera among the recording's sensors. */
  readonly sensor: number;
  readonly lattice: Lattice;
  /** `T_local_lattice`, row-major; null: the lattice is in local coordinates. */
  readonly mount: readonly number[] | null;
  /** Distance of each pixel in units, row by row; 0 without a point. */
  readonly depths: Uint16Array<ArrayBuffer>;
  /** The finest picture; null: in a segment the one before counts, else there is none. */
  readonly colours: Colours | null;
}

/** A picture as the browser's decoder has it. */
export interface Colours {
  readonly bytes: Uint8Array<ArrayBuffer>;
  /**
   * Of red, green and blue, or luma and the two chromas: the first byte, bytes a row, pixels that
   * share a value (power of two to the right, plus 16 times the power down), and bytes a value.
   */
  readonly planes: Int32Array;
  /** The planes are luma and chroma (JFIF). */
  readonly luma: boolean;
  /** Pixels of the depth image from one of the picture's to the next. */
  readonly step: number;
}

export interface Segment {
  readonly sequence: string;
  readonly frame: number;
  /** Points of the whole frame. */
  readonly total: number;
  /** The frame is complete with this segment. */
  readonly final: boolean;
  readonly count: number;
  readonly chunks: readonly SegmentChunk[];
  /**
   * `count` × 12 bytes: x, y, z uint16; r, g, b, intensity uint8; chunk and size uint16.  Empty with
   * a depth image.
   */
  readonly vertices: ArrayBuffer;
  /** Depth images with the pixels that have come so far; none where points come as points. */
  readonly images: readonly DepthImage[];
  /** Bytes on the wire, and the time to decode them. */
  readonly nbytes: number;
  readonly decodeMs: number;
}

/** The memory of a segment, which goes from thread to thread with it. */
export function buffersOf({ vertices, images }: Segment): ArrayBuffer[] {
  return [vertices, ...images.flatMap(imageBuffers)];
}

export function imageBuffers({ depths, colours }: DepthImage): ArrayBuffer[] {
  return colours ? [depths.buffer, colours.bytes.buffer] : [depths.buffer];
}

/** Return the metres between neighbouring points of a size code, at the level's own density. */
export function spacingOf(code: number): number {
  return SMALLEST * 2 ** (code / STEPS);
}

const SMALLEST = 0.0005;
const STEPS = 4;

export function sizeCode(spacing: number): number {
  const code = Math.round(Math.log2(spacing / SMALLEST) * STEPS);
  return code < 0 ? 0 : code >= SIZE_CODES ? SIZE_CODES - 1 : code;
}
