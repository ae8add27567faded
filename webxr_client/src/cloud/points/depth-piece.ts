/** Points of a depth image: their pixels and positions are computed once something asks for them. */
import type { DepthImage, SegmentChunk } from '../../net/chunk/segment';
import { unproject } from '../../net/depth/grid';
import { bandsOf, pointsOf } from '../../net/depth/lattice';
import type { Piece } from './piece';

interface Frame {
  readonly pieces: readonly Piece[];
  imageOf(sensor: number): DepthImage | undefined;
}

/** Pieces that keep their positions, of the frames that were aimed at or painted last. */
const MOST_KEPT = 64;
const kept: (() => void)[] = [];

/** The next chunk of one of a frame's images. */
export function depthPiece(frame: Frame, chunk: SegmentChunk): Piece {
  const { index, count, sensor } = chunk;
  const number = frame.pieces.filter((piece) => piece.sensor === sensor).length;
  let pixels: Uint32Array<ArrayBuffer> | null = null;
  let words: Uint16Array<ArrayBuffer> | null = null;
  const compute = (): Uint16Array<ArrayBuffer> => {
    const image = frame.imageOf(sensor)!;
    if (kept.length >= MOST_KEPT) kept.shift()!();
    kept.push(() => (words = piece.blocks = null));
    return unproject(image, chunk, index, bandsOf(image.lattice)[number]!, piece.pixels!);
  };
  const piece: Piece = {
    ...chunk,
    get words() {
      return (words ??= compute());
    },
    segment: null,
    get pixels() {
      if (pixels) return pixels;
      const { lattice, depths } = frame.imageOf(sensor)!;
      return (pixels = pointsOf(bandsOf(lattice)[number]!, lattice.width, depths, count));
    },
    blocks: null,
    labels: null,
    labelsVersion: 0,
  };
  return piece;
}
