import { readFileSync, writeFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import { decode, encode, unpackU16, unpackU32 } from './codec';
import type { ClientMessage } from './messages';

const GOLDEN = new URL('../../../tests/golden/', import.meta.url);

interface Entry {
  bytes: string;
  message: unknown;
}

function load(name: string): Entry[] {
  return JSON.parse(readFileSync(new URL(name, GOLDEN), 'utf8')) as Entry[];
}

/** JSON has no bytes: they are written as `{"$bytes": base64}`. */
function withBytes(value: unknown): unknown {
  if (Array.isArray(value)) return value.map(withBytes);
  if (typeof value !== 'object' || value === null) return value;
  if ('$bytes' in value) return new Uint8Array(Buffer.from(value.$bytes as string, 'base64'));
  return Object.fromEntries(Object.entries(value).map(([key, item]) => [key, withBytes(item)]));
}

const id = '5f0c8a52-0b0e-4c0a-8a50-3a3f6a4d9f11';
const CLIENT: ClientMessage[] = [
  { type: 'hello' },
  { type: 'hello', name: 'Zoë ☃', color: '#2fd5e0' },
  { type: 'open', sequence: 'juggling', frame: 3, revision: null },
  { type: 'open', sequence: 'juggling', frame: 0, revision: 2 ** 40 },
  { type: 'open', sequence: 'juggling', revision: 7, held: [[0, 12], [89, 1]] },
  { type: 'play', frame: 12, speed: -0.5, loop: false },
  { type: 'pause', frame: null },
  { type: 'seek', frame: 89 },
  { type: 'credit', frames: 1, nbytes: 1_300_000, decode_ms: 2.5, frame_ms: 0, target_ms: 16.7, points: null },
  { type: 'forget', frames: [1, 2, 300] },
  { type: 'want', frame: 0, chunks: [5, 4, 3] },
  {
    type: 'stroke_begin',
    id,
    frame: 7,
    brush: { label: 3, tool: 'paint', shape: 'ray', radius: 0.05, only_unlabeled: true, through: false },
  },
  {
    type: 'stroke_begin',
    id,
    frame: 7,
    brush: {
      tool: 'erase',
      shape: 'lasso',
      radius: 1,
      polygon: [
        [-0.5, -0.5],
        [0.5, -0.5],
        [0, 0.5],
      ],
      matrix: [1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],
    },
  },
  {
    type: 'stroke_samples',
    id,
    samples: [{ origin: [500000.25, 1, -2], direction: [0, 0, -1], t: 16.25 }],
  },
  { type: 'stroke_end', id },
  { type: 'stroke_cancel', id },
  { type: 'ask', id, frame: 3, brush: { label: 2, shape: 'object', negatives: [], candidate: '', level: null, previous: '', take_labelled: true, replaces: null }, samples: [{ origin: [0, 0, 0], direction: [0, 0, 1] }], negatives: [{ origin: [1, 0, 0], direction: [0, 0, 1], t: 0.5 }], previous: 'c0ffee' },
  { type: 'undo', id },
  { type: 'redo', id },
  { type: 'track', id, labels: [1, 2], start: 4, stop: 0, method: 'color-icp', overwrite: 'never' },
  { type: 'presence', frame: 2, head: [0, 1.6, 0, 0, 0, 0, 1], hands: [null], brush: [0, 1, 0], radius: 0.1, label: 4 },
]; // prettier-ignore

function golden(): Entry[] {
  return CLIENT.map((message) => ({
    bytes: Buffer.from(encode(message)).toString('base64'),
    message,
  }));
}

if (process.env['UPDATE_GOLDEN']) {
  writeFileSync(new URL('client_messages.json', GOLDEN), `${JSON.stringify(golden(), null, 1)}\n`);
}

describe('messages', () => {
  it('reads every message that Python writes', () => {
    for (const { bytes, message } of load('server_messages.json')) {
      expect(decode(new Uint8Array(Buffer.from(bytes, 'base64')))).toEqual(withBytes(message));
    }
  });

  it('writes the bytes that Python reads', () => {
    expect(golden()).toEqual(load('client_messages.json'));
  });

  it('leaves undefined fields out', () => {
    const message = { type: 'open', sequence: 's', frame: undefined } as unknown as ClientMessage;
    expect(decode(encode(message))).toEqual({ type: 'open', sequence: 's' });
  });

  it('refuses what is no message', () => {
    expect(() => decode(Uint8Array.of(0x93, 1, 2, 3))).toThrow('expected a map');
    expect(() => decode(Uint8Array.of(0x80))).toThrow('expected a map');
  });

  it('unpacks numbers from any byte offset', () => {
    const bytes = Uint8Array.of(9, 1, 0, 0, 0, 2, 1, 0, 0).subarray(1);
    expect([...unpackU32(bytes)]).toEqual([1, 258]);
    expect([...unpackU16(bytes.subarray(0, 4))]).toEqual([1, 0]);
  });
});
