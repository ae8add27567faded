/** Points of a depth image: their pixels and positions are computed once something asks for them. */
import type { DepthImage, SegmentChunk } from '../../net/chunk/segment';
import { unproject } from '../../net/depth/grid';
import { bandsOf, pointsOf } from '../../net/depth/lattice';
import type { Piece } from './piece';

/** Pieces that keep their positions, of the frames that were aimed at or painted last. */
const MOST_KEPT = 64;
const kept: (() => void)[] = [];

/** A chunk of a frame's image. */
export function depthPiece(
  frame: { readonly image: DepthImage | null },
  chunk: SegmentChunk,
): Piece {
  const { index, count } = chunk;
  let pixels: Uint32Array<ArrayBuffer> | null = null;
  let words: Uint16Array<ArrayBuffer> | null = null;
  const compute = (): Uint16Array<ArrayBuffer> => {
    const { lattice, depths } = frame.image!;
    if (kept.length >= MOST_KEPT) kept.shift()!();
    kept.push(() => (words = piece.blocks = null));
    return unproject(lattice, chunk, index, bandsOf(lattice)[index]!, piece.pixels!, depths);
  };
  const piece: Piece = {
    ...chunk,
    get words() {
      return (words ??= compute());
    },
    segment: null,
    get pixels() {
      if (pixels) return pixels;
      const { lattice, depths } = frame.image!;
      return (pixels = pointsOf(bandsOf(lattice)[index]!, lattice.width, depths, count));
    },
    blocks: null,
    labels: null,
    labelsVersion: 0,
  };
  return piece;
}
