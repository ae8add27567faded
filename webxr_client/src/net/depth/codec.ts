/** The bytes of a band: frequencies, tokens in rANS, and low bits (`docs/depth-format.md`). */

/** Contexts of pixels with both neighbours, by the bits of their difference; with one; with none. */
export const BOTH = 9;
export const ONE = 9;
export const NONE = 10;
const CONTEXTS = 11;
/** Remainders below this are tokens of their own; above, tokens stand for quarters of octaves. */
const DIRECT = 16;
const TOKENS = 1 + DIRECT + 4 * 14;
export const SCALE_BITS = 10;
export const SCALE = 1 << SCALE_BITS;
/** Pixels take turns with so many states. */
const STATES = 4;
/** A token's low bits begin in one byte and end in the third from there, or before. */
const MARGIN = 2;

const LENGTHS = 12;

export interface Parts {
  /** JPEG, empty where the chunk brings none. */
  readonly picture: Uint8Array;
  readonly tables: Uint8Array;
  readonly tokens: Uint8Array;
  readonly low: Uint8Array;
}

/** The four parts of a chunk's bytes. */
export function partsOf(data: Uint8Array): Parts {
  if (data.length < LENGTHS) throw new RangeError(`depth: expected ${LENGTHS} bytes or more`);
  const view = new DataView(data.buffer, data.byteOffset, LENGTHS);
  const picture = LENGTHS + view.getUint32(0, true);
  const tables = picture + view.getUint32(4, true);
  const tokens = tables + view.getUint32(8, true);
  if (tokens > data.length) throw new RangeError('depth: expected more bytes, got their end');
  return {
    picture: data.subarray(LENGTHS, picture),
    tables: data.subarray(picture, tables),
    tokens: data.subarray(tables, tokens),
    low: data.subarray(tokens),
  };
}

/** Value of each token without its low bits, and how many these are; of token 0, no point, nothing. */
export const [VALUES, LOW_BITS] = (() => {
  const values = new Uint16Array(TOKENS);
  const bits = new Uint8Array(TOKENS);
  for (let token = 1; token < TOKENS; token++) {
    const code = token - 1 - DIRECT;
    const count = code < 0 ? 0 : (code >> 2) + 2;
    bits[token] = count;
    values[token] = code < 0 ? token - 1 : (4 + (code & 3)) << count;
  }
  return [values, bits];
})();

/** A band's tokens and low bits, taken over to where a loop may read them beyond their ends. */
export class Streams {
  readonly states = new Uint32Array(STATES);
  words = new Uint16Array(0);
  low = new Uint8Array(0);
  private ends = { words: 0, low: 0 };

  take({ tokens, low }: Parts): void {
    const head = this.states.byteLength;
    if (tokens.length < head || tokens.length % 2 !== 0) {
      throw new RangeError(
        `depth: expected ${STATES} states and words, got ${tokens.length} bytes`,
      );
    }
    new Uint8Array(this.states.buffer).set(tokens.subarray(0, head));
    const words = (tokens.length - head) / 2;
    if (this.words.length <= words) this.words = new Uint16Array(2 * words + 1);
    new Uint8Array(this.words.buffer).set(tokens.subarray(head));
    if (this.low.length < low.length + MARGIN) this.low = new Uint8Array(2 * low.length + MARGIN);
    this.low.set(low);
    this.ends = { words, low: 8 * low.length };
  }

  /** Say so if more was read than there is. */
  check(words: number, lowBits: number): void {
    if (words > this.ends.words || lowBits > this.ends.low) {
      throw new RangeError('depth: expected more bytes, got their end');
    }
  }
}

/** Reads numbers of seven bits a byte, the lowest first. */
export class Numbers {
  private at = 0;

  constructor(private readonly bytes: Uint8Array) {}

  next(): number {
    let value = 0;
    for (let shift = 0; this.at < this.bytes.length; shift += 7) {
      const byte = this.bytes[this.at++]!;
      value |= (byte & 127) << shift;
      if (byte < 128) return value;
    }
    throw new RangeError('depth: expected a number, got the end of the bytes');
  }
}

/** An entry of `Tables`: token, its frequency less 1, and how far into it the state's low bits are. */
export const TOKEN_SHIFT = 2 * SCALE_BITS;

/** Entries by context and a state's low bits, `(context << SCALE_BITS) | bits`. */
export class Tables {
  readonly entries = new Uint32Array(CONTEXTS * SCALE);

  read(numbers: Numbers): void {
    for (let context = 0; context < CONTEXTS; context++) {
      const tokens = numbers.next();
      if (tokens > TOKENS) throw new RangeError(`depth: expected ${TOKENS} tokens at most`);
      let slot = context * SCALE;
      const end = slot + SCALE;
      for (let token = 0; token < tokens; token++) {
        const many = numbers.next();
        const stop = slot + many;
        if (stop > end) throw new RangeError(`depth: expected frequencies of a sum of ${SCALE}`);
        let entry = (token << TOKEN_SHIFT) | ((many - 1) << SCALE_BITS);
        while (slot < stop) this.entries[slot++] = entry++;
      }
      if (tokens > 0 && slot !== end) {
        throw new RangeError(`depth: expected frequencies of a sum of ${SCALE}`);
      }
    }
  }
}

/** The depths that pixels hold numbers of, from 1 on; empty when they hold depths. */
export function readListed(numbers: Numbers): Uint16Array {
  const listed = new Uint16Array(numbers.next());
  for (let i = 0, depth = 0; i < listed.length; i++) listed[i] = depth += numbers.next();
  return listed;
}
