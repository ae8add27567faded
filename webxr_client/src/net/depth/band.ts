/** One band of a depth image → vertices that the GPU takes as they are. */
import { sizeCode, MAX_CHUNKS, SIZE_CODES } from '../segment';
import type { Lattice } from '../../protocol/messages';
import {
  BOTH,
  LOW_BITS,
  NONE,
  ONE,
  SCALE,
  SCALE_BITS,
  TOKEN_SHIFT,
  VALUES,
  type Streams,
  type Tables,
} from './codec';
import { STRIP, type Band } from './lattice';

type Vector = readonly [number, number, number];

/** The grid of 16 bits that points are rounded to: the depth's own along the camera's axis. */
export interface Grid {
  readonly origin: Vector;
  readonly scale: Vector;
}

/** Colours of a frame's pixels that are `step` apart, row by row, of which the lowest three bytes count. */
export interface Colors {
  readonly pixels: Uint32Array;
  readonly width: number;
  readonly step: number;
}

/** Words of 32 bits in a vertex. */
const WORDS = 3;
const FARTHEST = 65535;
/** Bits of a word: a state of no more takes the next one. */
const WORD = 16;
/** So many depths share a size. */
const SIZE_SHIFT = 5;
/** Surfaces are seen askew, most of them by so much: their points lie farther apart. */
const SLANT = 1.15;
/** Black of a picture: where all three are zero the page shows grey by the intensity. */
const NEARLY_BLACK = 0x000100;

export function gridOf(lattice: Lattice, lo: Vector, hi: Vector): Grid {
  const { axis, sign, eye, unit } = lattice;
  const start = sign > 0 ? eye[axis]! : eye[axis]! - FARTHEST * unit;
  const along = (side: number, own: number, other: number) => (side === axis ? own : other);
  const origin = [0, 1, 2].map((side) => along(side, start, lo[side]!));
  const scale = [0, 1, 2].map((side) =>
    along(side, unit, Math.max((hi[side]! - lo[side]!) / FARTHEST, 1e-9)),
  );
  return { origin, scale } as unknown as Grid;
}

/** A band's way from pixels to vertices, as far as it is the same for all frames. */
export class BandPlan {
  /** Of each column or row of the lattice: units of the grid that a unit of depth goes aside. */
  private readonly slopes: readonly [Float64Array, Float64Array];
  private readonly starts: readonly [number, number];
  private readonly stamps = new Uint16Array((FARTHEST >> SIZE_SHIFT) + 1);

  constructor(
    private readonly lattice: Lattice,
    private readonly band: Band,
    chunk: number,
    grid: Grid,
  ) {
    const { width, height, axis, eye, unit, tangent, pitch } = lattice;
    const sides = [0, 1, 2].filter((side) => side !== axis);
    const slopes = [width, height].map((count, i) =>
      Float64Array.from(
        { length: count },
        (_, pixel) => (unit * (tangent[i]! + pitch[i]! * pixel)) / grid.scale[sides[i]!]!,
      ),
    );
    this.slopes = slopes as [Float64Array, Float64Array];
    const starts = sides.map((side) => (eye[side]! - grid.origin[side]!) / grid.scale[side]! + 0.5);
    this.starts = starts as [number, number];
    const apart = SLANT * Math.sqrt(pitch[0] * pitch[1] * band.down * band.across) * unit;
    const row = (chunk % MAX_CHUNKS) * SIZE_CODES;
    for (let i = 0; i < this.stamps.length; i++) {
      this.stamps[i] = row + sizeCode((i + 0.5) * apart * (1 << SIZE_SHIFT));
    }
  }

  /**
   * Decode the band's pixels into `image` (rows of `stride`, with a margin of zeros), and its points
   * into `vertices` (3 uint32 each).  Returns the points' number.
   */
  decode(
    image: Uint16Array,
    stride: number,
    streams: Streams,
    { entries }: Tables,
    listed: Uint16Array,
    colors: Colors | null,
    vertices: Uint32Array,
  ): number {
    const { width, axis, sign } = this.lattice;
    const { row: firstRow, stop, column: firstColumn, down, across, half, vertical } = this.band;
    const [columnSlopes, rowSlopes] = this.slopes;
    const [columnStart, rowStart] = this.starts;
    const { stamps } = this;
    const aside = (vertical ? half * stride : half) || across;
    const shift = Math.log2(colors?.step ?? 1);
    const pixels = colors?.pixels ?? null;
    const pictureWidth = colors?.width ?? 0;
    const coded = listed.length === 0;
    const room = vertices.length;
    const { words, low } = streams;
    // Pixels take turns with the states: four short chains of operations, side by side in the processor.
    let [state, second, third, fourth] = streams.states as unknown as [
      number,
      number,
      number,
      number,
    ];
    let at = 0;
    let bit = 0;
    let last = 0;
    let out = 0;
    for (let strip = firstRow; strip < stop; strip += STRIP * down) {
      const end = Math.min(strip + STRIP * down, stop);
      for (let column = firstColumn; column < width; column += across) {
        const columnSlope = columnSlopes[column]!;
        for (let row = strip; row < end; row += down) {
          const place = row * stride + column;
          // The expected value, by what is known beside it.
          let one: number;
          let other: number;
          let between = 0;
          if (half > 0) {
            one = image[place - aside]!;
            other = image[place + aside]!;
          } else {
            one = column >= across ? image[place - across]! : 0;
            other = row >= down ? image[place - down * stride]! : 0;
            if (one !== 0 && other !== 0) between = image[place - down * stride - across]!;
          }
          let expected: number;
          let context: number;
          if (one !== 0 && other !== 0) {
            expected = (one + other) >> 1;
            if (between !== 0) {
              const least = Math.min(one, other);
              const most = Math.max(one, other);
              expected = Math.min(Math.max(one + other - between, least), most);
            }
            context = Math.min(32 - Math.clz32(Math.abs(one - other)), BOTH - 1);
          } else if (one !== 0 || other !== 0) {
            expected = one + other;
            context = ONE;
          } else {
            expected = last;
            context = NONE;
          }
          // The token.
          const entry = entries[(context << SCALE_BITS) | (state & (SCALE - 1))]!;
          const many = ((entry >>> SCALE_BITS) & (SCALE - 1)) + 1;
          const next = Math.imul(many, state >>> SCALE_BITS) + (entry & (SCALE - 1));
          // All bits where a word is needed, else none: nothing for the processor to guess.
          const needs = ((next >>> WORD) - 1) >> 31;
          state = second;
          second = third;
          third = fourth;
          fourth = (next << (needs & WORD)) | (words[at]! & needs);
          at -= needs;
          const token = entry >>> TOKEN_SHIFT;
          if (token === 0) continue;
          const bits = LOW_BITS[token]!;
          const byte = bit >> 3;
          const rest = (low[byte]! | (low[byte + 1]! << 8) | (low[byte + 2]! << 16)) >> (bit & 7);
          const folded = VALUES[token]! + (rest & ((1 << bits) - 1));
          bit += bits;
          last = (expected + ((folded >> 1) ^ -(folded & 1))) & FARTHEST;
          image[place] = last;
          // The vertex.
          if (out >= room) throw new RangeError('depth: expected fewer points');
          const depth = coded ? last : listed[last - 1]!;
          const x = (columnStart + depth * columnSlope) & 0xffff;
          const y = (rowStart + depth * rowSlopes[row]!) & 0xffff;
          const z = sign > 0 ? depth : FARTHEST - depth;
          let rgb = 0;
          if (pixels !== null) {
            rgb = pixels[(row >> shift) * pictureWidth + (column >> shift)]! & 0xffffff;
            if (rgb === 0) rgb = NEARLY_BLACK;
          }
          vertices[out] = axis === 2 ? x | (y << 16) : axis === 1 ? x | (z << 16) : z | (x << 16);
          vertices[out + 1] = (axis === 2 ? z : y) | (rgb << 16);
          vertices[out + 2] = (rgb >>> 16) | (stamps[depth >> SIZE_SHIFT]! << 16);
          out += WORDS;
        }
      }
    }
    streams.check(at, bit);
    return out / WORDS;
  }
}
