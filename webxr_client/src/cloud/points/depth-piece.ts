/** Points of a depth image: their positions are computed once something asks for them. */
import type { DepthImage, SegmentChunk } from '../../net/chunk/segment';
import { unproject } from '../../net/depth/grid';
import { bandsOf } from '../../net/depth/lattice';
import type { Piece } from './piece';

/** Pieces that keep their positions, of the frames that were aimed at or painted last. */
const MOST_KEPT = 64;
const kept: (() => void)[] = [];

/** A chunk of a frame's image; `vertices`: of its segment. */
export function depthPiece(
  frame: { readonly image: DepthImage | null },
  chunk: SegmentChunk,
  vertices: ArrayBuffer,
): Piece {
  const { index, start, count } = chunk;
  const pixels = new Uint32Array(vertices, start * Uint32Array.BYTES_PER_ELEMENT, count);
  let words: Uint16Array<ArrayBuffer> | null = null;
  const compute = (): Uint16Array<ArrayBuffer> => {
    const { lattice, depths } = frame.image!;
    if (kept.length >= MOST_KEPT) kept.shift()!();
    kept.push(() => (words = piece.blocks = null));
    return unproject(lattice, chunk, index, bandsOf(lattice)[index]!, pixels, depths);
  };
  const piece: Piece = {
    ...chunk,
    get words() {
      return (words ??= compute());
    },
    segment: null,
    pixels,
    blocks: null,
    labels: null,
    labelsVersion: 0,
  };
  return piece;
}
