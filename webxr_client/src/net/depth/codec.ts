/** The bytes of a band: frequencies, tokens in rANS, and low bits (`docs/depth-format.md`). */

const CONTEXTS = 11;
/** Remainders below this have separate tokens; above, tokens represent quarters of octaves. */
const DIRECT = 16;
const TOKENS = 1 + DIRECT + 4 * 14;
const MOST_LOW_BITS = 15;
const SCALE_BITS = 10;
const SCALE = 1 << SCALE_BITS;
/** Bytes that are read ahead of need, of words and of low bits. */
const WORD_BYTES = 2;
const AHEAD = 4;
const STATES_BYTES = 16;

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

/** Room for the tokens of so many pixels: each takes a word at most. */
export function tokenBytes(pixels: number): number {
  return STATES_BYTES + WORD_BYTES * (pixels + 1);
}

/** Room for the low bits of so many pixels. */
export function lowBytes(pixels: number): number {
  return Math.ceil((MOST_LOW_BITS * pixels) / 8) + AHEAD;
}

/** Of each token its value without low bits, and in the lowest five bits how many these are. */
export const TOKEN_VALUES = Uint32Array.from({ length: TOKENS }, (_, token) => {
  const code = token - 1 - DIRECT;
  if (code < 0) return Math.max(token - 1, 0) << 5;
  const bits = (code >> 2) + 2;
  return ((4 + (code & 3)) << (bits + 5)) | bits;
});

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

export const ENTRIES = CONTEXTS * SCALE;

/**
 * Read a chunk's frequencies: entries by context and the lowest bits of a state.  An entry is a token,
 * its frequency less 1, and how far into it the state is.
 */
export function writeEntries(entries: Uint32Array, numbers: Numbers): void {
  for (let context = 0; context < CONTEXTS; context++) {
    const tokens = numbers.next();
    if (tokens > TOKENS) throw new RangeError(`depth: expected ${TOKENS} tokens at most`);
    let slot = context * SCALE;
    const end = slot + SCALE;
    for (let token = 0; token < tokens; token++) {
      const many = numbers.next();
      const stop = slot + many;
      if (stop > end) throw new RangeError(`depth: expected frequencies of a sum of ${SCALE}`);
      let entry = (token << (2 * SCALE_BITS)) | ((many - 1) << SCALE_BITS);
      while (slot < stop) entries[slot++] = entry++;
    }
    if (tokens > 0 && slot !== end) {
      throw new RangeError(`depth: expected frequencies of a sum of ${SCALE}`);
    }
  }
}

/** The depths that pixels hold numbers of, from 1 on; empty when they hold depths. */
export function readListed(numbers: Numbers): Uint16Array {
  const listed = new Uint16Array(numbers.next());
  for (let i = 0, depth = 0; i < listed.length; i++) listed[i] = depth += numbers.next();
  return listed;
}
