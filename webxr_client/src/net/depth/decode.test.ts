import { readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import { CloudFrame } from '../../cloud/points/frame';
import { decode } from '../../protocol/codec';
import type { Depth, DepthChunk, Lattice, SequenceInfo } from '../../protocol/messages';
import { ready } from '../chunk/decode';
import { BufferPool } from '../chunk/pool';
import { spacingOf, type Segment } from '../chunk/segment';
import { DepthDecoder } from './decode';
import { unproject } from './grid';
import { bandsOf, pointsOf } from './lattice';
import type { Picture } from './pictures';

const GOLDEN = new URL('../../../../tests/golden/', import.meta.url);

interface Golden {
  lattice: Lattice;
  lo: [number, number, number];
  hi: [number, number, number];
  position_error: number;
  count: number;
  chunks: DepthChunk[];
  xyz_base64: string;
  pixels: number[];
  pictures: { width: number; nbytes: number; rgb_base64: string }[];
}

interface Rig {
  position_error: number;
  every: number;
  xyz_base64: string;
  sensor: number[];
  sensors: SequenceInfo['sensors'];
}

function readGolden(name: string): { data: Uint8Array; golden: Golden; xyz: Float32Array } {
  const data = new Uint8Array(readFileSync(new URL(`depth_${name}.bin`, GOLDEN)));
  const text = readFileSync(new URL(`depth_${name}.json`, GOLDEN), 'utf8');
  const golden = JSON.parse(text) as Golden;
  const bytes = new Uint8Array(Buffer.from(golden.xyz_base64, 'base64'));
  return { data, golden, xyz: new Float32Array(bytes.buffer) };
}

/** Pictures as Pillow reads them: no browser is here to do it. */
function pictureOf(golden: Golden, jpeg: Uint8Array): Picture {
  const { width, rgb_base64 } = golden.pictures.find(({ nbytes }) => nbytes === jpeg.length)!;
  const rgb = Buffer.from(rgb_base64, 'base64');
  const height = rgb.length / (3 * width);
  return {
    width,
    height,
    read: () =>
      Promise.resolve({ bytes: Uint8Array.from(rgb), planes: new Int32Array(12), luma: false }),
    close: () => undefined,
  };
}

type View = Pick<Golden, 'lattice' | 'lo' | 'hi'>;

function decoderOf(golden: Golden, { lattice, lo, hi }: View = golden): DepthDecoder {
  const read = (jpeg: Uint8Array) => Promise.resolve(pictureOf(golden, jpeg));
  const decoder = new DepthDecoder(new BufferPool(1 << 20), read);
  decoder.open({ identity: 'i', lattice, lo, hi, sensors: [] as unknown } as SequenceInfo);
  return decoder;
}

/** Chunks [first, stop) of a frame as a message. */
function message(data: Uint8Array, { chunks, count }: Golden, first: number, stop: number): Depth {
  const start = chunks[first]!.offset;
  const rows = chunks
    .slice(first, stop)
    .map((row) => ({ ...row, sensor: 0, offset: row.offset - start }));
  const end = rows.at(-1)!.offset + rows.at(-1)!.nbytes;
  return {
    type: 'depth',
    sequence: 's',
    frame: 3,
    total: count,
    final: stop === chunks.length,
    chunks: rows,
    data: data.subarray(start, start + end),
  };
}

/** The words of a segment's points, chunk by chunk. */
function wordsOf({ chunks, images: [image] }: Segment): Uint16Array[] {
  const { lattice, depths } = image!;
  return chunks.map((chunk) => {
    const band = bandsOf(lattice)[chunk.index]!;
    const pixels = pointsOf(band, lattice.width, depths, chunk.count);
    return unproject(image!, chunk, chunk.index, band, pixels);
  });
}

function positions(segment: Segment): number[][] {
  return wordsOf(segment).flatMap((words, c) => {
    const { count, origin, scale } = segment.chunks[c]!;
    return Array.from({ length: count }, (_, i) =>
      [0, 1, 2].map((side) => origin[side]! + words[i * 6 + side]! * scale[side]!),
    );
  });
}

describe.each(['fine', 'coarse'])('a %s depth image that Python encoded', (name) => {
  const { data, golden, xyz } = readGolden(name);

  it('has every point where it is, in its order, whole and in parts', async () => {
    let whole: Uint16Array | null = null;
    for (const parts of [
      [0, golden.chunks.length],
      [0, 1, 2, golden.chunks.length],
    ]) {
      const decoder = decoderOf(golden);
      const found: number[][] = [];
      let depths = new Uint16Array();
      for (let i = 0; i + 1 < parts.length; i++) {
        const coming = decoder.receive(message(data, golden, parts[i]!, parts[i + 1]!));
        const segment = await decoder.decode(coming);
        found.push(...positions(segment));
        depths = segment.images[0]!.depths;
      }
      expect(depths).toEqual((whole ??= depths));
      expect(found.length).toBe(golden.count);
      const off = found.map((at, i) =>
        Math.max(...at.map((value, side) => Math.abs(value - xyz[3 * i + side]!))),
      );
      expect(Math.max(...off)).toBeLessThanOrEqual(golden.position_error);
    }
  });

  it.each([0, 1, 2].flatMap((axis) => [1, -1].map((sign) => ({ axis, sign }))))(
    'has every point in the box of a camera that looks along $axis times $sign',
    async ({ axis, sign }) => {
      const lattice = { ...golden.lattice, axis, sign };
      const { width, eye, unit, tangent, pitch } = lattice;
      const sides = [0, 1, 2].filter((side) => side !== axis);
      const seen = golden.pixels.map((pixel, i) => {
        const along = unit * Math.round((xyz[3 * i + 2]! - eye[2]) / unit);
        const at = [...eye];
        at[axis]! += sign * along;
        [pixel % width, Math.floor(pixel / width)].forEach((place, i) => {
          at[sides[i]!]! += along * (tangent[i]! + pitch[i]! * place);
        });
        return at;
      });
      const extent = (most: typeof Math.max) =>
        [0, 1, 2].map((side) => most(...seen.map((at) => at[side]!)));
      // A box that is too small on both sides.
      const lo = extent(Math.min).map((value) => value + 0.05);
      const hi = extent(Math.max).map((value) => value - 0.05);
      const decoder = decoderOf(golden, { lattice, lo, hi } as unknown as View);
      const all = await decoder.decode(
        decoder.receive(message(data, golden, 0, golden.chunks.length)),
      );
      const off = positions(all).map((at, i) =>
        Math.max(
          ...at.map((value, side) => {
            const whole = seen[i]![side]!;
            const bounded = Math.min(Math.max(whole, lo[side]!), hi[side]!);
            return Math.abs(value - (side === axis ? whole : bounded));
          }),
        ),
      );
      expect(Math.max(...off)).toBeLessThanOrEqual(golden.position_error);
    },
  );

  it('has the colours of the finest picture that came', async () => {
    const decoder = decoderOf(golden);
    const all = await decoder.decode(
      decoder.receive(message(data, golden, 0, golden.chunks.length)),
    );
    const finest = golden.pictures.find(({ width }) => width === golden.lattice.width)!;
    const rgb = Buffer.from(finest.rgb_base64, 'base64');
    const { bytes, step } = all.images[0]!.colours!;
    expect(step).toBe(1);
    expect(Buffer.from(bytes).equals(rgb)).toBe(true);
  });

  it('stamps each point with its chunk and the spacing of its level', async () => {
    const decoder = decoderOf(golden);
    const all = await decoder.decode(
      decoder.receive(message(data, golden, 0, golden.chunks.length)),
    );
    const words = wordsOf(all);
    for (const { index, first, count } of all.chunks) {
      const apart = Math.sqrt((golden.lattice.width * golden.lattice.height) / count);
      for (let i = 0; i < count; i += 7) {
        const stamp = words[index]![i * 6 + 5]!;
        const depth = xyz[3 * (first + i) + 2]! - golden.lattice.eye[2];
        expect(stamp >> 6).toBe(index);
        const ratio = spacingOf(stamp & 63) / (depth * golden.lattice.pitch[0] * apart);
        expect(ratio).toBeGreaterThan(0.9);
        expect(ratio).toBeLessThan(1.4);
      }
    }
  });

  it('gives no points of what does not join on, and reads on from the start', async () => {
    const decoder = decoderOf(golden);
    await decoder.decode(decoder.receive(message(data, golden, 0, 1)));
    decoder.forget([3]);
    const late = await decoder.decode(decoder.receive(message(data, golden, 1, 2)));
    expect(late.count).toBe(0);
    const anew = await decoder.decode(decoder.receive(message(data, golden, 0, 2)));
    expect(anew.count).toBe(golden.chunks[0]!.count + golden.chunks[1]!.count);
  });

  it('refuses bytes that are cut off', async () => {
    const decoder = decoderOf(golden);
    const cut = message(data, golden, 0, 1);
    const chunk = { ...cut.chunks[0]!, nbytes: cut.chunks[0]!.nbytes - 200 };
    const decode = async () => decoder.decode(decoder.receive({ ...cut, chunks: [chunk] }));
    await expect(decode()).rejects.toThrow('depth');
  });
});

describe('a frame of two depth cameras and a lidar that Python encoded', () => {
  const golden = JSON.parse(readFileSync(new URL('sensors.json', GOLDEN), 'utf8')) as Rig;
  const messages = [0, 1].map((i) => {
    const bytes = readFileSync(new URL(`sensors_${i}.bin`, GOLDEN));
    return decode(new Uint8Array(bytes).buffer) as Depth;
  });
  // Only the size, from the frame header of the JPEG: no browser is here to read it.
  const read = (jpeg: Uint8Array): Promise<Picture> => {
    const at = jpeg.findIndex((byte, i) => byte === 0xff && jpeg[i + 1] === 0xc0);
    const [height, width] = [5, 7].map((i) => 256 * jpeg[at + i]! + jpeg[at + i + 1]!) as [number, number]; // prettier-ignore
    return Promise.resolve({
      ...{ width, height },
      read: () => Promise.resolve({ bytes: new Uint8Array(), planes: new Int32Array(12), luma: false }), // prettier-ignore
      close: () => undefined,
    });
  };
  const openedDecoder = (): DepthDecoder => {
    const decoder = new DepthDecoder(new BufferPool(1 << 20), read);
    decoder.open({ identity: 'i', lattice: null, ...golden } as unknown as SequenceInfo);
    return decoder;
  };

  it('has every point where its mount puts it, an image a camera, and points beside them', async () => {
    await ready;
    const decoder = openedDecoder();
    const frame = new CloudFrame(0, false);
    for (const message of messages) {
      frame.add(await decoder.decode(decoder.receive(message)));
    }
    expect(frame.complete).toBe(true);
    expect(frame.images.map(({ sensor }) => sensor)).toEqual([0, 1]);
    const xyz = new Float32Array(new Uint8Array(Buffer.from(golden.xyz_base64, 'base64')).buffer);
    golden.sensor.forEach((sensor, i) => {
      const number = golden.every * i;
      const piece = frame.pieceOf(number)!;
      expect(piece.sensor).toBe(sensor);
      const { T_frame_sensor: mounts, correction } = golden.sensors[sensor]!;
      const moved = Math.hypot(...[3, 7, 11].map((at) => correction[at]!));
      const away = [3, 7, 11].map((at, k) => piece.eye[k]! - mounts[0]![at]!);
      expect(Math.hypot(...away)).toBeCloseTo(moved, 6);
      for (const k of [0, 1, 2] as const) {
        const at = piece.origin[k] + piece.words[6 * (number - piece.first) + k]! * piece.scale[k];
        expect(Math.abs(at - xyz[3 * i + k]!)).toBeLessThanOrEqual(golden.position_error);
      }
    });
  });

  it('gives no points of a camera whose earlier chunks were forgotten', async () => {
    const decoder = openedDecoder();
    await decoder.decode(decoder.receive(messages[0]!));
    decoder.forget([0]);
    expect((await decoder.decode(decoder.receive(messages[1]!))).count).toBe(0);
  });
});
