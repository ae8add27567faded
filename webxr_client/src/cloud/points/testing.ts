/** Frames for tests: points as the worker would hand them over. */
import { finishChunk } from '../../net/chunk/density';
import { STRIDE, type Segment, type SegmentChunk } from '../../net/chunk/segment';
import { CloudFrame } from './frame';

type Vector = [number, number, number];
const SCALE = 0.001;

/** Chunks of points (millimetres, 0..65535) as one segment. */
export function segmentOf(
  parts: readonly (readonly Vector[])[],
  options: Partial<Segment> & { from?: number } = {},
): Segment {
  const count = parts.reduce((sum, part) => sum + part.length, 0);
  const vertices = new ArrayBuffer(count * STRIDE);
  const words = new Uint16Array(vertices);
  const chunks: SegmentChunk[] = [];
  const from = options.from ?? 0;
  let start = 0;
  parts.forEach((part, level) => {
    part.forEach((point, i) => words.set(point, (start + i) * 6));
    const origin: Vector = [0, 0, 0];
    const scale: Vector = [SCALE, SCALE, SCALE];
    const view = new Uint32Array(vertices, start * STRIDE, part.length * 3);
    finishChunk(view, part.length, origin, scale, level, 0);
    const corner = (pick: (...values: number[]) => number): Vector =>
      [0, 1, 2].map((k) => pick(...part.map((point) => point[k]!)) * SCALE) as Vector;
    const [lo, hi] = [corner(Math.min), corner(Math.max)];
    const first = from + start;
    chunks.push({ index: from + level, level, first, count: part.length, sensor: 0, eye: origin, start, origin, scale, lo, hi }); // prettier-ignore
    start += part.length;
  });
  return {
    sequence: 's',
    frame: 0,
    total: from + count,
    final: true,
    count,
    chunks,
    vertices,
    images: [],
    nbytes: 0,
    decodeMs: 0,
    ...options,
  };
}

/** A wall of points 10 mm apart, `size` × `size`, at z millimetres. */
export function wall(size: number, z: number): Vector[] {
  return Array.from({ length: size * size }, (_, i) => [
    (i % size) * 10,
    Math.floor(i / size) * 10,
    z,
  ]);
}

export function frameOf(...parts: (readonly Vector[])[]): CloudFrame {
  const frame = new CloudFrame(0, false);
  frame.add(segmentOf(parts));
  return frame;
}

/** The same round the origin, up to 30 m away. */
export function frameAround(points: readonly Vector[]): CloudFrame {
  const segment = segmentOf([points.map(([x, y, z]) => [x + 30000, y + 30000, z + 30000])]);
  const chunks = segment.chunks.map((chunk) => ({ ...chunk, origin: [-30, -30, -30] as const }));
  const frame = new CloudFrame(0, false);
  frame.add({ ...segment, chunks });
  return frame;
}
