/** Messages ⇄ msgpack bytes.  Types come from the server's models; see `messages.ts`. */
import { Decoder, Encoder } from '@msgpack/msgpack';
import type { ClientMessage, ServerMessage } from './messages';

const encoder = new Encoder({ ignoreUndefined: true });
const decoder = new Decoder();

/** The bytes of a message, in a buffer of its own. */
export function encode(message: ClientMessage): Uint8Array<ArrayBuffer> {
  return encoder.encode(message);
}

/**
 * A message from its bytes.  Packed arrays in it are views into `bytes`, not copies.
 * Throws when the bytes are not a map with a `type`.
 */
export function decode(bytes: Uint8Array | ArrayBuffer): ServerMessage {
  const value: unknown = decoder.decode(bytes);
  if (typeof value !== 'object' || value === null || !('type' in value)) {
    throw new TypeError(`message: expected a map with "type", got ${typeof value}`);
  }
  return value as ServerMessage;
}

/** Little-endian packed numbers as a typed array; copied, since bytes may lie unaligned. */
export function unpackU32(bytes: Uint8Array): Uint32Array<ArrayBuffer> {
  return new Uint32Array(bytes.slice().buffer);
}

export function unpackF32(bytes: Uint8Array): Float32Array<ArrayBuffer> {
  return new Float32Array(bytes.slice().buffer);
}

export function unpackU16(bytes: Uint8Array): Uint16Array<ArrayBuffer> {
  return new Uint16Array(bytes.slice().buffer);
}

/** Runs (first number and length, uint32 each) of sorted point numbers, some of them repeated. */
export function runsOf(numbers: Uint32Array): Uint8Array<ArrayBuffer> {
  const runs: number[] = [];
  let end = -1;
  for (const number of numbers) {
    if (number === end) runs[runs.length - 1]! += 1;
    else if (number > end) runs.push(number, 1);
    end = number + 1;
  }
  return new Uint8Array(Uint32Array.from(runs).buffer);
}

/** Point numbers from runs (first number and length, uint32 each). */
export function numbersOf(bytes: Uint8Array): Uint32Array {
  return expanded(new Uint32Array(bytes.slice().buffer));
}

/** The same from a REST answer, which has a pair of numbers for each run. */
export function numbersOfRuns(runs: readonly (readonly number[])[]): Uint32Array {
  return expanded(Uint32Array.from(runs.flat()));
}

function expanded(runs: Uint32Array): Uint32Array {
  let count = 0;
  for (let i = 1; i < runs.length; i += 2) count += runs[i]!;
  const numbers = new Uint32Array(count);
  let at = 0;
  for (let i = 0; i < runs.length; i += 2) {
    for (let k = 0; k < runs[i + 1]!; k++) numbers[at++] = runs[i]! + k;
  }
  return numbers;
}
