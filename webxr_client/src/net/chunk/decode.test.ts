import { readFileSync } from 'node:fs';
import { beforeAll, describe, expect, it } from 'vitest';
import type { Chunk, Frame, SequenceInfo } from '../../protocol/messages';
import { decodeFrame, ready } from './decode';
import { finishChunk } from './density';
import { BufferPool } from './pool';
import { spacingOf, type Segment } from './segment';

const GOLDEN = new URL('../../../../tests/golden/', import.meta.url);
const data = new Uint8Array(readFileSync(new URL('frame_small.bin', GOLDEN)));
const golden = JSON.parse(readFileSync(new URL('frame_small.json', GOLDEN), 'utf8')) as {
  count: number;
  chunks: Chunk[];
  decoded_base64: string;
};
const alone = { sensors: [] as unknown } as SequenceInfo;
const message: Frame = {
  type: 'frame',
  sequence: 's',
  frame: 4,
  total: golden.count,
  final: true,
  chunks: golden.chunks,
  data,
};

describe('a frame that Python encoded', () => {
  let segment: Segment;

  beforeAll(async () => {
    await ready;
    segment = decodeFrame(message, alone, new BufferPool(1 << 20));
  });

  it('has the very points', () => {
    const expected = Buffer.from(golden.decoded_base64, 'base64');
    const bytes = Buffer.from(segment.vertices, 0, segment.count * 12);
    expect(segment.count).toBe(golden.count);
    for (let point = 0; point < segment.count; point++) {
      const at = point * 12;
      // The last two bytes are free on the wire, and carry the page's stamp.
      expect(bytes.compare(expected, at, at + 10, at, at + 10)).toBe(0);
    }
  });

  it('stamps each point with its chunk and about the spacing of its level', () => {
    const words = new Uint16Array(segment.vertices);
    for (const chunk of segment.chunks) {
      const spacings: number[] = [];
      for (let i = 0; i < chunk.count; i++) {
        const stamp = words[(chunk.start + i) * 6 + 5]!;
        expect(stamp >> 6).toBe(chunk.index);
        spacings.push(spacingOf(stamp & 63));
      }
      spacings.sort((a, b) => a - b);
      // The bowl's grid is 1/64 m; a level with a part of the points is as much sparser.
      const expected = (1 / 64) * Math.sqrt(golden.count / chunk.count);
      const median = spacings[spacings.length >> 1]!;
      expect(median).toBeGreaterThan(0.6 * expected);
      expect(median).toBeLessThan(2 * expected);
    }
  });

  it('reads what an older version imported', () => {
    const text = readFileSync(new URL('vertices_v0.json', GOLDEN), 'utf8');
    const old = JSON.parse(text) as { count: number; data_base64: string; decoded_base64: string };
    const bytes = new Uint8Array(Buffer.from(old.data_base64, 'base64'));
    const chunk = { ...golden.chunks[0]!, count: old.count, offset: 0, nbytes: bytes.length };
    const read = decodeFrame({ ...message, chunks: [chunk], data: bytes }, alone, new BufferPool(1 << 20)); // prettier-ignore
    const expected = Buffer.from(old.decoded_base64, 'base64');
    const got = Buffer.from(read.vertices, 0, old.count * 12);
    for (let at = 0; at < expected.length; at += 12) {
      expect(got.compare(expected, at, at + 10, at, at + 10)).toBe(0);
    }
  });

  it('gives colours that lost their lowest bits, or share two bytes, the whole range again', () => {
    const words = new Uint32Array(3);
    const bytes = new Uint8Array(words.buffer);
    for (const [flags, sent, shown] of [
      [4, [0, 1, 63], [0, 4, 255]],
      [2, [127, 64, 1], [255, 129, 2]],
      [5, [2, 1, 0], [12, 4, 4]],
      [6, [0, 0, 0], [0, 0, 0]],
      [6, [255, 255, 0], [255, 255, 255]],
      [6, [1 | (5 << 5), (41 >> 3) | (30 << 3), 0], [8, 182, 247]],
    ] as const) {
      bytes.set(sent, 6);
      finishChunk(words, 1, [0, 0, 0], [1, 1, 1], 0, flags);
      expect([...bytes.subarray(6, 9)]).toEqual(shown);
    }
  });

  it('makes a point that is alone, and few points far apart, large enough to be seen', () => {
    const metre = [1 / 1024, 1 / 1024, 1 / 1024] as const;
    const sizes = (words: Uint32Array, count: number, x = 1): number => {
      finishChunk(words, count, [x, 0, 0], metre, 0, 0);
      return spacingOf((words[2]! >>> 16) & 63);
    };
    expect(sizes(new Uint32Array(3), 1)).toBeGreaterThan(0.003);
    // At the sensor itself, too.
    expect(sizes(new Uint32Array(3), 1, 0)).toBeGreaterThan(0.003);
    // Four corners of a square, a metre apart.
    const [far, both] = [1024, 1024 | (1024 << 16)];
    const square = new Uint32Array([0, 0, 0, far, 0, 0, 1024 << 16, 0, 0, both, 0, 0]);
    expect(sizes(square, 4)).toBeGreaterThan(0.1);
  });

  it('refuses bytes that are cut off', () => {
    const [chunk] = golden.chunks;
    const cut: Frame = { ...message, chunks: [{ ...chunk!, nbytes: 100 }] };
    expect(() => decodeFrame(cut, alone, new BufferPool(1 << 20))).toThrow();
  });
});

describe('the pool of buffers', () => {
  it('gives a returned buffer again when it fits', () => {
    const pool = new BufferPool(1 << 20);
    const first = pool.take(100_000);
    pool.give(first);
    expect(pool.take(90_000)).toBe(first);
    expect(pool.take(90_000)).not.toBe(first);
  });

  it('keeps no more than its limit', () => {
    const pool = new BufferPool(100_000);
    const [a, b] = [pool.take(65_536), pool.take(65_536)];
    pool.give(a);
    pool.give(b);
    expect(pool.take(65_536)).toBe(a);
    expect(pool.take(65_536)).not.toBe(b);
  });
});
