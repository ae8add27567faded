/** Local density of decoded points: how large each must be drawn to fill the surface. */
import { sizeCode, SIZE_CODES, STRIDE } from './segment';

/** A point without neighbours is drawn this large for its distance from the sensor, and so many metres at least. */
const [LONE, LEAST_LONE] = [0.005, 0.005];
/** Points of a run, which give the local spacing by their extent; every eighth is used. */
const RUN = 64;
const EVERY = 8;
/** Words of 32 bits in a vertex. */
const WORDS = 3;
/** The same of 16 bits, and which of them takes the stamp; the byte of red, ahead of green and blue. */
const HALVES = 6;
const STAMP = 5;
const RED = 6;
/**
 * Flags on the wire: r and b are less g; so many low bits of r, g and b are left out, or the bytes
 * of r and g hold all three with 5, 6 and 5 bits.
 */
const RELATIVE = 1;
const DROPPED = 6;
const DROPPED_SHIFT = 1;
const PACKED = 3;
const RUNS = 65536 / RUN;
const MANY = 256;
const spacings = new Float32Array(RUNS);
const distances = new Float32Array(RUNS);
/** Number of runs from which the rule of spacings is found. */
const SAMPLES = 128;
const samples = new Float32Array(SAMPLES);
/** A rule holds when half the runs are this near to it, relatively. */
const TIGHT = 1;
/** A run's box against the patch in it, measured on patches of known spacing. */
const BOX_EXCESS = 0.8;
/** Number of steps from point to point that are measured in a run. */
const STEPS = 6;
/** The shorter steps are this much below the spacing of a grid with noise. */
const STEP_EXCESS = 1.15;

export type Vector = readonly [number, number, number];

/**
 * Make decoded vertices ready to draw: each gets its chunk and size code, and colours that came as
 * differences to green, or without their lowest bits (`flags`), their own values.
 *
 * Neighbours in Morton order are neighbours in space, so a run of them covers a patch of surface
 * with an area that gives the distance between its points.  A run across an edge measures the gap
 * instead; it is corrected by the rule that most runs follow: spacing grows with the distance from
 * the sensor (cameras, lidars), or is the same everywhere (merged scans).
 * `vertices` is a view of the chunk's points, 3 uint32 each: x y, z r g, b i and the stamp.
 */
export function finishChunk(
  vertices: Uint32Array,
  count: number,
  origin: Vector,
  scale: Vector,
  chunk: number,
  flags: number,
): void {
  const runs = Math.min(RUNS, Math.ceil(count / RUN));
  measure(vertices, runs, count, origin, scale);
  const rule = findRule(runs);
  const halves = new Uint16Array(vertices.buffer, vertices.byteOffset, count * HALVES);
  for (let run = 0; run < runs; run++) {
    const usual = rule.grows ? rule.factor * distances[run]! : rule.factor;
    const found = Math.min(rule.most * usual, Math.max(rule.least * usual, spacings[run]!));
    const stamp = chunk * SIZE_CODES + sizeCode(rule.share * found);
    const stop = Math.min(count, (run + 1) * RUN) * HALVES;
    for (let i = run * RUN * HALVES + STAMP; i < stop; i += HALVES) halves[i] = stamp;
  }
  if ((flags & (RELATIVE | DROPPED)) === 0) return;
  const bytes = new Uint8Array(vertices.buffer, vertices.byteOffset, count * STRIDE);
  if (flags & RELATIVE) addGreen(bytes);
  const dropped = (flags & DROPPED) >> DROPPED_SHIFT;
  if (dropped === PACKED) unpack(bytes);
  else if (dropped) widen(bytes, dropped);
}

function addGreen(bytes: Uint8Array): void {
  for (let i = RED; i < bytes.length; i += STRIDE) {
    const green = bytes[i + 1]!;
    bytes[i] = bytes[i]! + green;
    bytes[i + 2] = bytes[i + 2]! + green;
  }
}

/** Give colours of 8 − `bits` bits the range of eight. */
function widen(bytes: Uint8Array, bits: number): void {
  const high = 8 - 2 * bits;
  for (let i = RED; i < bytes.length; i += STRIDE) {
    for (let colour = i; colour < i + 3; colour++) {
      const value = bytes[colour]!;
      bytes[colour] = (value << bits) | (value >> high);
    }
  }
}

/** Give colours of 5, 6 and 5 bits in two bytes a byte each. */
function unpack(bytes: Uint8Array): void {
  for (let i = RED; i < bytes.length; i += STRIDE) {
    const low = bytes[i]!;
    const high = bytes[i + 1]!;
    const red = low & 31;
    const green = (low >> 5) | ((high & 7) << 3);
    const blue = high >> 3;
    bytes[i] = (red << 3) | (red >> 2);
    bytes[i + 1] = (green << 2) | (green >> 4);
    bytes[i + 2] = (blue << 3) | (blue >> 2);
  }
}

interface Rule {
  /** Spacing grows with the distance from the sensor. */
  readonly grows: boolean;
  readonly factor: number;
  /** Greatest departure of a run from the rule. */
  readonly least: number;
  readonly most: number;
  /** Part of the spacing that a point should fill. */
  readonly share: number;
}

function findRule(runs: number): Rule {
  const same = middle(runs, false);
  const grows = middle(runs, true);
  const best = grows.spread < same.spread ? grows : same;
  const holds = best.spread < TIGHT;
  return {
    grows: best === grows,
    factor: best.median,
    least: holds ? 0.75 : 0.15,
    most: holds ? 1.4 : 1.7,
    // Scattered points and single scan lines make no surface, however large their discs.
    share: holds ? 1 : 0.5,
  };
}

/** Median of the runs' spacings (over their distance), and how far apart they are around it. */
function middle(runs: number, perDistance: boolean): { median: number; spread: number } {
  const step = Math.max(1, Math.floor(runs / SAMPLES));
  let n = 0;
  for (let run = 0; run < runs && n < SAMPLES; run += step) {
    samples[n++] = perDistance ? spacings[run]! / distances[run]! : spacings[run]!;
  }
  const sorted = samples.subarray(0, n).sort();
  // Edges only ever enlarge a run: the usual one lies below the median.
  const median = sorted[Math.floor(n * 0.4)] ?? 1e-3;
  const spread =
    ((sorted[Math.floor(n * 0.65)] ?? 0) - (sorted[Math.floor(n * 0.15)] ?? 0)) / median;
  return { median, spread };
}

/** Spacing of each run, and its distance from the sensor. */
function measure(
  vertices: Uint32Array,
  runs: number,
  count: number,
  origin: Vector,
  scale: Vector,
): void {
  const [ox, oy, oz] = origin;
  const [sx, sy, sz] = scale;
  // In a chunk of many runs, patches resemble their neighbours: two share one measurement.
  const step = runs > MANY ? 2 : 1;
  for (let run = 0; run < runs; run += step) {
    const first = run * RUN;
    const n = Math.min(count - first, RUN);
    const stop = (first + n) * WORDS;
    // Of few points each counts.
    const every = (n > EVERY ? EVERY : 1) * WORDS;
    let loX = 65535, loY = 65535, loZ = 65535, hiX = 0, hiY = 0, hiZ = 0; // prettier-ignore
    for (let i = first * WORDS; i < stop; i += every) {
      const xy = vertices[i]!;
      const x = xy & 0xffff;
      const y = xy >>> 16;
      const z = vertices[i + 1]! & 0xffff;
      loX = Math.min(loX, x);
      hiX = Math.max(hiX, x);
      loY = Math.min(loY, y);
      hiY = Math.max(hiY, y);
      loZ = Math.min(loZ, z);
      hiZ = Math.max(hiZ, z);
    }
    const patch = spacing((hiX - loX) * sx, (hiY - loY) * sy, (hiZ - loZ) * sz, n);
    const near = n > 2 * STEPS ? STEP_EXCESS * nearStep(vertices, first, sx, sy, sz) : patch;
    spacings[run] = Math.min(patch, Math.max(near, 0.3 * patch));
    const x = ox + ((loX + hiX) / 2) * sx;
    const y = oy + ((loY + hiY) / 2) * sy;
    const z = oz + ((loZ + hiZ) / 2) * sz;
    distances[run] = Math.max(1e-6, Math.sqrt(x * x + y * y + z * z));
    if (n === 1) spacings[run] = Math.max(LEAST_LONE, LONE * distances[run]!);
    if (step > 1) {
      spacings[run + 1] = spacings[run]!;
      distances[run + 1] = distances[run]!;
    }
  }
}

/**
 * The second shortest step between neighbours of a run, metres.  On a lidar's rings it is the
 * distance along the ring, where the patch's area would count the gaps between the rings.
 */
function nearStep(
  vertices: Uint32Array,
  first: number,
  sx: number,
  sy: number,
  sz: number,
): number {
  let shortest = Infinity;
  let second = Infinity;
  let at = (first + 4) * WORDS;
  let xy = vertices[at]!;
  let x0 = xy & 0xffff;
  let y0 = xy >>> 16;
  let z0 = vertices[at + 1]! & 0xffff;
  for (let i = 0; i < STEPS; i++) {
    at += WORDS;
    xy = vertices[at]!;
    const x1 = xy & 0xffff;
    const y1 = xy >>> 16;
    const z1 = vertices[at + 1]! & 0xffff;
    const x = (x1 - x0) * sx;
    const y = (y1 - y0) * sy;
    const z = (z1 - z0) * sz;
    const step = x * x + y * y + z * z;
    if (step < shortest) {
      second = shortest;
      shortest = step;
    } else if (step < second) second = step;
    x0 = x1;
    y0 = y1;
    z0 = z1;
  }
  return Math.sqrt(second);
}

/** Distance between `n` points spread over a patch with these extents: an area, or a line. */
function spacing(a: number, b: number, c: number, n: number): number {
  const longest = Math.max(a, b, c);
  const shortest = Math.min(a, b, c);
  const middle = a + b + c - longest - shortest;
  return Math.max(BOX_EXCESS * Math.sqrt((longest * middle) / n), longest / n, 1e-6);
}
