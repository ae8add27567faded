import { describe, expect, it } from 'vitest';
import type { Colours, Segment } from '../../net/chunk/segment';
import type { Lattice } from '../../protocol/messages';
import { CloudFrame } from './frame';
import { firstHit } from './pick';

const SIDE = 96;
const LATTICE: Lattice = {
  width: SIDE,
  height: SIDE,
  axis: 2,
  sign: 1,
  tangent: [-0.48, -0.48],
  pitch: [0.01, 0.01],
  eye: [0, 0, 0],
  unit: 0.001,
};
const COLOURS: Colours = {
  bytes: new Uint8Array(8),
  planes: new Int32Array(12),
  luma: false,
  step: 2,
};

/** A wall two metres away: every second pixel of every second row, then the pixels between them. */
function wall(level: 0 | 1, colours: Colours | null): Segment {
  const half = SIDE / 2;
  const pixels = Array.from(
    { length: half * half },
    (_, i) => 2 * Math.floor(i / half) * SIDE + 2 * (i % half) + level,
  );
  const depths = new Uint16Array(SIDE * SIDE);
  for (const pixel of pixels) depths[pixel] = depths[pixel - level] = 2000;
  const [origin, scale] = [[-1, -1, 0], [1 / 32768, 1 / 32768, 0.001]] as const; // prettier-ignore
  const first = level * pixels.length;
  const chunk = { index: level, level, first, count: pixels.length, sensor: 0, eye: origin, start: 0, origin, scale, lo: origin, hi: [1, 1, 2] }; // prettier-ignore
  return {
    sequence: 's',
    frame: 0,
    total: 2 * pixels.length,
    final: level === 1,
    count: pixels.length,
    chunks: [chunk as unknown as Segment['chunks'][number]],
    vertices: new ArrayBuffer(0),
    images: [{ sensor: 0, mount: null, lattice: LATTICE, depths, colours }],
    nbytes: 0,
    decodeMs: 0,
  };
}

describe('a frame that comes as a depth image', () => {
  const frame = new CloudFrame(0, false);
  const [coarse, fine] = [wall(0, COLOURS), wall(1, null)];

  it('keeps the colours while it sharpens, and counts what it holds', () => {
    expect(frame.add(coarse)).toBe(true);
    expect(frame.add(fine)).toBe(true);
    expect(frame.complete).toBe(true);
    expect(frame.images).toMatchObject([{ depths: fine.images[0]!.depths, colours: COLOURS }]);
    const vertices = coarse.vertices.byteLength + fine.vertices.byteLength;
    expect(frame.bytes).toBe(vertices + 2 * SIDE * SIDE + COLOURS.bytes.length);
  });

  it('is met by a ray where its pixels say', () => {
    const pixel = 20 * SIDE + 31;
    const way = [-0.48 + 0.31, -0.48 + 0.2, 1].map((part) => part / Math.hypot(0.17, 0.28, 1));
    const hit = firstHit(frame, [0, 0, 0], way as [number, number, number], 0.005)!;
    const piece = frame.pieceOf(hit.point)!;
    expect(piece.pixels![hit.point - piece.first]).toBe(pixel);
    expect(hit.position[2]).toBeCloseTo(2, 2);
  });

  it('gives all its memory back', () => {
    expect(frame.release()).toHaveLength(4);
    expect(frame.bytes).toBe(0);
    expect(frame.images).toEqual([]);
  });
});
