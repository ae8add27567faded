/** Bounds and local density of decoded points, in one pass over them. */
import { BLOCK, BLOCK_VALUES, sizeCode, SIZE_CODES } from './segment';

/** Points whose common extent gives the local spacing. */
const RUN = 16;
const RUNS_PER_BLOCK = BLOCK / RUN;
const RUNS = 65536 / RUN;
const spacings = new Float32Array(RUNS);
const distances = new Float32Array(RUNS);
/** Runs looked at to find the rule that spacings follow. */
const SAMPLES = 128;
const samples = new Float32Array(SAMPLES);
/** A rule holds when half the runs are this near to it, relatively. */
const TIGHT = 1;
/** A run's box is larger than the patch in it: measured on patches of known spacing. */
const BOX_EXCESS = 0.7;

/** Steps from point to point looked at in a run. */
const STEPS = 6;
/** The shorter steps are this much below the spacing of a grid with noise. */
const STEP_EXCESS = 1.15;
const steps = new Float32Array(STEPS);

export type Vector = readonly [number, number, number];

export function blockCount(points: number): number {
  return Math.ceil(points / BLOCK);
}

/**
 * Fill the blocks' bounds and stamp each vertex with its chunk and size code.
 *
 * Neighbours in Morton order are neighbours in space, so a run of them covers a patch of surface
 * whose area says how far its points lie apart.  A run across an edge measures the gap instead;
 * it is put right by the rule that most runs follow: spacing grows with the distance from the
 * sensor (cameras, lidars), or is the same everywhere (merged scans).
 * `vertices` is a view of the chunk's points, 6 uint16 each; `blocks` starts at its first block.
 */
export function finishChunk(
  vertices: Uint16Array,
  count: number,
  origin: Vector,
  scale: Vector,
  chunk: number,
  blocks: Uint16Array,
): void {
  const runs = Math.min(RUNS, Math.ceil(count / RUN));
  measureRuns(vertices, count, origin, scale, blocks);
  const rule = findRule(runs);
  for (let run = 0; run < runs; run++) {
    const usual = rule.grows ? rule.factor * distances[run]! : rule.factor;
    const found = Math.min(rule.most * usual, Math.max(rule.least * usual, spacings[run]!));
    const spacing = rule.share * found;
    const stamp = chunk * SIZE_CODES + sizeCode(spacing);
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

function measureRuns(
  vertices: Uint16Array,
  count: number,
  origin: Vector,
  scale: Vector,
  blocks: Uint16Array,
): void {
  const [scaleX, scaleY, scaleZ] = scale;
  for (let run = 0, first = 0; first < count; run++, first += RUN) {
    const stop = Math.min(count, first + RUN);
    let loX = 65535, loY = 65535, loZ = 65535, hiX = 0, hiY = 0, hiZ = 0; // prettier-ignore
    for (let i = first * 6; i < stop * 6; i += 6) {
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
    const block = ((run / RUNS_PER_BLOCK) | 0) * BLOCK_VALUES;
    const fresh = run % RUNS_PER_BLOCK === 0;
    if (fresh || loX < blocks[block]!) blocks[block] = loX;
    if (fresh || loY < blocks[block + 1]!) blocks[block + 1] = loY;
    if (fresh || loZ < blocks[block + 2]!) blocks[block + 2] = loZ;
    if (fresh || hiX > blocks[block + 3]!) blocks[block + 3] = hiX;
    if (fresh || hiY > blocks[block + 4]!) blocks[block + 4] = hiY;
    if (fresh || hiZ > blocks[block + 5]!) blocks[block + 5] = hiZ;
    const n = stop - first;
    const patch = spacing((hiX - loX) * scaleX, (hiY - loY) * scaleY, (hiZ - loZ) * scaleZ, n);
    const near = n > STEPS + 4 ? STEP_EXCESS * nearStep(vertices, first, scale) : patch;
    spacings[run] = Math.min(patch, Math.max(near, 0.3 * patch));
    distances[run] = Math.max(
      1e-6,
      Math.hypot(
        origin[0] + ((loX + hiX) / 2) * scaleX,
        origin[1] + ((loY + hiY) / 2) * scaleY,
        origin[2] + ((loZ + hiZ) / 2) * scaleZ,
      ),
    );
  }
}

/**
 * The second shortest step between neighbours of a run, metres.  On a lidar's rings it is the
 * distance along the ring, where the patch's area would count the gaps between the rings.
 */
function nearStep(vertices: Uint16Array, first: number, scale: Vector): number {
  for (let k = 0, i = (first + 4) * 6; k < STEPS; k++, i += 6) {
    const x = (vertices[i]! - vertices[i + 6]!) * scale[0];
    const y = (vertices[i + 1]! - vertices[i + 7]!) * scale[1];
    const z = (vertices[i + 2]! - vertices[i + 8]!) * scale[2];
    steps[k] = x * x + y * y + z * z;
  }
  let shortest = Infinity;
  let second = Infinity;
  for (const step of steps) {
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
