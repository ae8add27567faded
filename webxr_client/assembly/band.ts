/**
 * AssemblyScript: one band of a depth image → depths, and the pixels that have a point (docs/depth-format.md).
 * Arguments of type `usize` are addresses in the memory that the page gives.
 */

const STRIP: i32 = 16;
/** Contexts of pixels with both neighbours, by the bits of their difference; with one; with none. */
const BOTH: i32 = 9;
const ONE: i32 = 9;
const NONE: i32 = 10;
const SCALE_BITS: u32 = 10;
const FREQUENCY: u32 = (1 << SCALE_BITS) - 1;
const STATES: usize = 16;
/** Bits of a word: a state of no more takes the next one. */
const WORD: u32 = 16;
const FARTHEST: i32 = 65535;
const LOW_COUNT: u32 = 31;
const LOW_SHIFT: u32 = 5;

function depthAt(place: usize): i32 {
  return <i32>load<u16>(place);
}

/**
 * Decode a band's pixels into an image of uint16 with a margin.
 * Returns the points' number, -1 where words or low bits ended too early.
 */
export function decode(
  image: usize,
  /** Pixels from row to row. */
  stride: i32,
  /** The band's pixels; `half` and `vertical` say where its neighbours are, as in `Band`. */
  firstRow: i32,
  stop: i32,
  firstColumn: i32,
  width: i32,
  down: i32,
  across: i32,
  half: i32,
  vertical: bool,
  /** Entries by context and state; of each token its value << 5 and number of low bits. */
  entries: usize,
  tokens: usize,
  /** Four states with words behind them, to their end; low bits, and how many. */
  states: usize,
  wordsEnd: usize,
  low: usize,
  lowBits: usize,
): i32 {
  // Pixels take turns with the states: four short chains of operations, side by side in the processor.
  let state = load<u32>(states);
  let second = load<u32>(states, 4);
  let third = load<u32>(states, 8);
  let fourth = load<u32>(states, 12);
  let words = states + STATES;
  let bit: usize = 0;
  let last = 0;
  let points = 0;
  const left = (<usize>across) << 1;
  const above = (<usize>(down * stride)) << 1;
  const aside = (<usize>(vertical ? half * stride : half)) << 1;
  for (let strip = firstRow; strip < stop; strip += STRIP * down) {
    const end = min<i32>(strip + STRIP * down, stop);
    for (let column = firstColumn; column < width; column += across) {
      let place = image + ((<usize>(strip * stride + column)) << 1);
      for (let row = strip; row < end; row += down, place += above) {
        // The expected value, by what is known beside it.
        let one: i32;
        let other: i32;
        let between = 0;
        if (half > 0) {
          one = depthAt(place - aside);
          other = depthAt(place + aside);
        } else {
          one = column >= across ? depthAt(place - left) : 0;
          other = row >= down ? depthAt(place - above) : 0;
          if (one != 0 && other != 0) between = depthAt(place - above - left);
        }
        let expected: i32;
        let context: i32;
        if (one != 0 && other != 0) {
          expected = (one + other) >> 1;
          if (between != 0) {
            const most = max<i32>(one, other);
            expected = min<i32>(max<i32>(one + other - between, min<i32>(one, other)), most);
          }
          context = min<i32>(32 - clz<i32>(abs<i32>(one - other)), BOTH - 1);
        } else if ((one | other) != 0) {
          expected = one + other;
          context = ONE;
        } else {
          expected = last;
          context = NONE;
        }
        // The token; whether a word is needed is nothing for the processor to guess.
        const index = ((<u32>context) << SCALE_BITS) | (state & FREQUENCY);
        const entry = load<u32>(entries + ((<usize>index) << 2));
        const many = ((entry >> SCALE_BITS) & FREQUENCY) + 1;
        const next = many * (state >> SCALE_BITS) + (entry & FREQUENCY);
        const needs = next >> WORD == 0;
        state = second;
        second = third;
        third = fourth;
        fourth = select<u32>((next << WORD) | load<u16>(words), next, needs);
        words += (<usize>needs) << 1;
        const token = entry >> (2 * SCALE_BITS);
        if (token == 0) continue;
        const told = load<u32>(tokens + ((<usize>token) << 2));
        const bits = told & LOW_COUNT;
        const rest = (load<u32>(low + (bit >> 3)) >> (<u32>(bit & 7))) & ((1 << bits) - 1);
        const folded = <i32>((told >> LOW_SHIFT) + rest);
        bit += bits;
        last = (expected + ((folded >>> 1) ^ -(folded & 1))) & FARTHEST;
        store<u16>(place, <u16>last);
        points += 1;
      }
    }
  }
  if (words > wordsEnd || bit > lowBits) return -1;
  return points;
}
