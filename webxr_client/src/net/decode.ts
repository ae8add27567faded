/** A frame message → vertices that the GPU takes as they are. */
import { MeshoptDecoder } from 'meshoptimizer/decoder';
import type { Frame } from '../protocol/messages';
import { blockCount, finishChunk } from './blocks';
import type { BufferPool } from './pool';
import { BLOCK_VALUES, MAX_CHUNKS, STRIDE, type Segment, type SegmentChunk } from './segment';

/** Resolves once the WASM decoder can be used. */
export const ready: Promise<void> = MeshoptDecoder.ready;

/** Decode all chunks of a message, one after another, into a buffer of the pool. */
export function decodeFrame(message: Frame, pool: BufferPool): Segment {
  const started = performance.now();
  let points = 0;
  let blocksTotal = 0;
  for (const chunk of message.chunks) {
    points += chunk.count;
    blocksTotal += blockCount(chunk.count);
  }
  const vertices = pool.take(points * STRIDE);
  const blocks = new Uint16Array(blocksTotal * BLOCK_VALUES);
  const chunks: SegmentChunk[] = [];
  let start = 0;
  let block = 0;
  for (const chunk of message.chunks) {
    const { offset, nbytes, count } = chunk;
    const target = new Uint8Array(vertices, start * STRIDE, count * STRIDE);
    const source = message.data.subarray(offset, offset + nbytes);
    MeshoptDecoder.decodeVertexBuffer(target, count, STRIDE, source);
    finishChunk(
      new Uint16Array(vertices, start * STRIDE, count * 6),
      count,
      chunk.origin,
      chunk.scale,
      chunk.index % MAX_CHUNKS,
      blocks.subarray(block * BLOCK_VALUES),
    );
    chunks.push({ ...chunk, start, block });
    start += count;
    block += blockCount(count);
  }
  return {
    sequence: message.sequence,
    frame: message.frame,
    total: message.total,
    final: message.final,
    count: points,
    chunks,
    vertices,
    blocks,
    nbytes: message.data.byteLength,
    decodeMs: performance.now() - started,
  };
}
