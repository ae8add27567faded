/** A run of decoded points as the worker hands it to the page. */

export const STRIDE = 12;
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
  /** Offset of the points in the segment's vertices, in points. */
  readonly start: number;
  readonly origin: readonly [number, number, number];
  readonly scale: readonly [number, number, number];
  readonly lo: readonly [number, number, number];
  readonly hi: readonly [number, number, number];
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
  /** `count` × 12 bytes: x, y, z uint16; r, g, b, intensity uint8; chunk and size uint16. */
  readonly vertices: ArrayBuffer;
  /** Bytes on the wire, and the time to decode them. */
  readonly nbytes: number;
  readonly decodeMs: number;
}

/** Metres between neighbouring points that a size code stands for, at the level's own density. */
export function spacingOf(code: number): number {
  return SMALLEST * 2 ** (code / STEPS);
}

const SMALLEST = 0.0005;
const STEPS = 4;

export function sizeCode(spacing: number): number {
  const code = Math.round(Math.log2(spacing / SMALLEST) * STEPS);
  return code < 0 ? 0 : code >= SIZE_CODES ? SIZE_CODES - 1 : code;
}
