/** A frame message → vertices that the GPU takes as they are. */
import { MeshoptDecoder } from 'meshoptimizer/decoder';
import type { Chunk, Frame, SequenceInfo } from '../../protocol/messages';
import { finishChunk } from './density';
import { boxGrid, eyeOf, mountOf, move } from './grid';
import type { BufferPool } from './pool';
import { MAX_CHUNKS, STRIDE, WORDS, type Segment, type SegmentChunk } from './segment';

/** Offset of the flags in a chunk's vertices on the wire. */
const FLAGS = 10;

/** Resolves once the WASM decoder can be used. */
export const ready: Promise<void> = MeshoptDecoder.ready;

/** Decode a message of points. */
export function decodeFrame(message: Frame, info: SequenceInfo, pool: BufferPool): Segment {
  const started = performance.now();
  const { sequence, frame, total, final, data } = message;
  const { vertices, chunks } = decodeChunks(message.chunks, message, info, pool);
  const count = chunks.reduce((sum, chunk) => sum + chunk.count, 0);
  const [nbytes, decodeMs] = [data.byteLength, performance.now() - started];
  return { sequence, frame, total, final, count, chunks, vertices, images: [], nbytes, decodeMs };
}

/**
 * Decode chunks of points one after another into a buffer of the pool.  Those of several sensors
 * move to local coordinates.
 */
export function decodeChunks(
  given: readonly Chunk[],
  { frame, data }: Pick<Frame, 'frame' | 'data'>,
  info: SequenceInfo,
  pool: BufferPool,
): { vertices: ArrayBuffer; chunks: SegmentChunk[] } {
  const points = given.reduce((sum, chunk) => sum + chunk.count, 0);
  const vertices = points > 0 ? pool.take(points * STRIDE) : new ArrayBuffer(0);
  const chunks: SegmentChunk[] = [];
  let start = 0;
  for (const chunk of given) {
    const { offset, nbytes, count, origin, scale } = chunk;
    const sensor = chunk.sensor ?? 0;
    const target = new Uint8Array(vertices, start * STRIDE, count * STRIDE);
    MeshoptDecoder.decodeVertexBuffer(target, count, STRIDE, data.subarray(offset, offset + nbytes)); // prettier-ignore
    const flags = count > 0 ? target[FLAGS]! : 0;
    const words = new Uint32Array(vertices, start * STRIDE, count * 3);
    finishChunk(words, count, origin, scale, chunk.index % MAX_CHUNKS, flags);
    const mount = mountOf(info, sensor, frame);
    const grid = mount ? boxGrid(info.lo, info.hi) : { origin, scale };
    if (mount) move(new Uint16Array(vertices, start * STRIDE, count * WORDS), chunk, mount, grid);
    chunks.push({ ...chunk, ...grid, sensor, eye: eyeOf(mount), start });
    start += count;
  }
  return { vertices, chunks };
}
