/** Local density of decoded points: how large each must be drawn to fill the surface. */
import { sizeCode, SIZE_CODES } from './segment';

/** Points whose common extent gives the local spacing; every eighth is looked at. */
const RUN = 64;
const STRIDE_WORDS = 8 * 6;
const RUNS = 65536 / RUN;
const spacings = new Float32Array(RUNS);
const distances = new Float32Array(RUNS);
/** Runs looked at to find the rule that spacings follow. */
const SAMPLES = 128;
const samples = new Float32Array(SAMPLES);
/** A rule holds when half the runs are this near to it, relatively. */
const TIGHT = 1;
/** A run's box against the patch in it, measured on patches of known spacing. */
const BOX_EXCESS = 0.8;
/** Steps from point to point looked at in a run. */
const STEPS = 6;
/** The shorter steps are this much below the spacing of a grid with noise. */
const STEP_EXCESS = 1.15;

export type Vector = readonly [number, number, number];

/**
 * Stamp each vertex with its chunk and size code.
 *
 * Neighbours in Morton order are neighbours in space, so a run of them covers a patch of surface
 * whose area says how far its points lie apart.  A run across an edge measures the gap instead;
 * it is put right by the rule that most runs follow: spacing grows with the distance from the
 * sensor (cameras, lidars), or is the same everywhere (merged scans).
 * `vertices` is a view of the chunk's points, 6 uint16 each.
 */
export function stampChunk(
  vertices: Uint16Array,
  count: number,
  origin: Vector,
  scale: Vector,
  chunk: number,
): void {
  const runs = Math.min(RUNS, Math.ceil(count / RUN));
  for (let run = 0; run < runs; run++) measure(vertices, run, count, origin, scale);
  const rule = findRule(runs);
  for (let run = 0; run < runs; run++) {
    const usual = rule.grows ? rule.factor * distances[run]! : rule.factor;
    const found = Math.min(rule.most * usual, Math.max(rule.least * usual, spacings[run]!));
    const stamp = chunk * SIZE_CODES + sizeCode(rule.share * found);
    const stop = Math.min(count, (run + 1) * RUN) * 6;
    for (let i = run * RUN * 6 + 5; i < stop; i += 6) vertices[i] = stamp;
  }
}

interface Rule {
  /** Spacing grows with the distance from the sensor. */
  readonly grows: boolean;
  readonly factor: number;
  /** How far a run may depart from the rule. */
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

/** Spacing of one run, and its distance from the sensor. */
function measure(
  vertices: Uint16Array,
  run: number,
  count: number,
  origin: Vector,
  scale: Vector,
): void {
  const first = run * RUN;
  const n = Math.min(count - first, RUN);
  const stop = (first + n) * 6;
  let loX = 65535, loY = 65535, loZ = 65535, hiX = 0, hiY = 0, hiZ = 0; // prettier-ignore
  for (let i = first * 6; i < stop; i += STRIDE_WORDS) {
    const x = vertices[i]!;
    const y = vertices[i + 1]!;
    const z = vertices[i + 2]!;
    if (x < loX) loX = x;
    if (x > hiX) hiX = x;
    if (y < loY) loY = y;
    if (y > hiY) hiY = y;
    if (z < loZ) loZ = z;
    if (z > hiZ) hiZ = z;
  }
  const patch = spacing((hiX - loX) * scale[0], (hiY - loY) * scale[1], (hiZ - loZ) * scale[2], n);
  const near = n > 2 * STEPS ? STEP_EXCESS * nearStep(vertices, first, scale) : patch;
  spacings[run] = Math.min(patch, Math.max(near, 0.3 * patch));
  const x = origin[0] + ((loX + hiX) / 2) * scale[0];
  const y = origin[1] + ((loY + hiY) / 2) * scale[1];
  const z = origin[2] + ((loZ + hiZ) / 2) * scale[2];
  distances[run] = Math.max(1e-6, Math.sqrt(x * x + y * y + z * z));
}

/**
 * The second shortest step between neighbours of a run, metres.  On a lidar's rings it is the
 * distance along the ring, where the patch's area would count the gaps between the rings.
 */
function nearStep(vertices: Uint16Array, first: number, scale: Vector): number {
  let shortest = Infinity;
  let second = Infinity;
  const stop = (first + 4 + STEPS) * 6;
  for (let i = (first + 4) * 6; i < stop; i += 6) {
    const x = (vertices[i]! - vertices[i + 6]!) * scale[0];
    const y = (vertices[i + 1]! - vertices[i + 7]!) * scale[1];
    const z = (vertices[i + 2]! - vertices[i + 8]!) * scale[2];
    const step = x * x + y * y + z * z;
    if (step < shortest) {
      second = shortest;
      shortest = step;
    } else if (step < second) second = step;
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
