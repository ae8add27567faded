/** A frame message → vertices that the GPU takes as they are. */
import { MeshoptDecoder } from 'meshoptimizer/decoder';
import type { Frame } from '../../protocol/messages';
import { finishChunk } from './density';
import type { BufferPool } from './pool';
import { MAX_CHUNKS, STRIDE, type Segment, type SegmentChunk } from './segment';

/** Offset of the flags in a chunk's vertices on the wire. */
const FLAGS = 10;

/** Resolves once the WASM decoder can be used. */
export const ready: Promise<void> = MeshoptDecoder.ready;

/** Decode all chunks of a message, one after another, into a buffer of the pool. */
export function decodeFrame(message: Frame, pool: BufferPool): Segment {
  const started = performance.now();
  const points = message.chunks.reduce((sum, chunk) => sum + chunk.count, 0);
  const vertices = pool.take(points * STRIDE);
  const chunks: SegmentChunk[] = [];
  let start = 0;
  for (const chunk of message.chunks) {
    const { offset, nbytes, count, origin, scale } = chunk;
    const target = new Uint8Array(vertices, start * STRIDE, count * STRIDE);
    const source = message.data.subarray(offset, offset + nbytes);
    MeshoptDecoder.decodeVertexBuffer(target, count, STRIDE, source);
    const flags = count > 0 ? target[FLAGS]! : 0;
    const words = new Uint32Array(vertices, start * STRIDE, count * 3);
    finishChunk(words, count, origin, scale, chunk.index % MAX_CHUNKS, flags);
    chunks.push({ ...chunk, start });
    start += count;
  }
  return {
    sequence: message.sequence,
    frame: message.frame,
    total: message.total,
    final: message.final,
    count: points,
    chunks,
    vertices,
    image: null,
    nbytes: message.data.byteLength,
    decodeMs: performance.now() - started,
  };
}
