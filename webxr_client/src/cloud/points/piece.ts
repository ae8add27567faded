/** The points of one chunk in the page's memory, with their labels. */
import type { LabelUpdate } from '../../net/wire';
import { spacingOf, STRIDE, WORDS, type SegmentChunk } from '../../net/chunk/segment';
import { hiddenSensors } from '../../store/sensors';
import { boundBlocks } from './blocks';

/** The value of a deleted point on the wire. */
export const DELETED = 65535;

/** The points of one chunk.  Views share the buffer of the segment that brought them. */
export interface Piece {
  readonly index: number;
  readonly level: number;
  readonly sensor: number;
  readonly eye: readonly [number, number, number];
  /** Stored number of the first point. */
  readonly first: number;
  readonly count: number;
  readonly origin: readonly [number, number, number];
  readonly scale: readonly [number, number, number];
  readonly lo: readonly [number, number, number];
  readonly hi: readonly [number, number, number];
  /** 6 uint16 a point: x, y, z quantised; colours; stamp. */
  readonly words: Uint16Array<ArrayBuffer>;
  /** All bytes of the segment, 12 a point, where this piece's are; null: of a depth image. */
  readonly segment: Uint8Array<ArrayBuffer> | null;
  /** Of a depth image: each point's pixel. */
  readonly pixels: Uint32Array<ArrayBuffer> | null;
  /** Bounds of each 256 points; made when a ray or a brush first comes near. */
  blocks: Uint16Array | null;
  /** One id a point; null while all are 0. */
  labels: Uint16Array | null;
  /** Grows with every change of `labels`. */
  labelsVersion: number;
}

/** A chunk of points as they lie in a segment's bytes. */
export function pieceOf(chunk: SegmentChunk, segment: Uint8Array<ArrayBuffer>): Piece {
  const words = new Uint16Array(segment.buffer, chunk.start * STRIDE, chunk.count * WORDS);
  return { ...chunk, words, segment, pixels: null, blocks: null, labels: null, labelsVersion: 0 };
}

/** Whether its sensor is hidden here: rays pass its points, and strokes leave them. */
export function isHidden({ sensor }: Piece): boolean {
  return hiddenSensors.peek().has(sensor);
}

/** Take the server's values, run by run. */
export function applyRuns(piece: Piece, update: LabelUpdate): void {
  const { lengths, values } = update;
  const stop = piece.first + piece.count;
  let number = update.first;
  for (let run = 0; run < lengths.length && number < stop; run++) {
    const end = number + lengths[run]!;
    const value = values[run]!;
    if (end > piece.first && (value !== 0 || piece.labels)) {
      piece.labels ??= new Uint16Array(piece.count);
      piece.labelsVersion += 1;
      piece.labels.fill(
        value,
        Math.max(number, piece.first) - piece.first,
        Math.min(end, stop) - piece.first,
      );
    }
    number = end;
  }
}

/** Take the server's values of single points; `numbers` are sorted. */
export function applyDelta(piece: Piece, numbers: Uint32Array, values: Uint16Array): void {
  const stop = piece.first + piece.count;
  let at = lowerBound(numbers, piece.first);
  if (at >= numbers.length || numbers[at]! >= stop) return;
  piece.labels ??= new Uint16Array(piece.count);
  piece.labelsVersion += 1;
  const single = values.length === 1;
  for (; at < numbers.length && numbers[at]! < stop; at++) {
    piece.labels[numbers[at]! - piece.first] = values[single ? 0 : at]!;
  }
}

/** Position of the first of sorted `numbers` that is not below `number`. */
export function lowerBound(numbers: Uint32Array, number: number): number {
  let low = 0;
  let high = numbers.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (numbers[middle]! < number) low = middle + 1;
    else high = middle;
  }
  return low;
}

export function blocksOf(piece: Piece): Uint16Array {
  piece.blocks ??= boundBlocks(piece.words, piece.count);
  return piece.blocks;
}

/** Metres between neighbouring points near a point of a piece. */
export function spacingAt(piece: Piece, point: number, factor: number): number {
  return spacingOf(piece.words[point * 6 + 5]! & 63) * factor;
}
