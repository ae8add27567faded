/** Bounds and local density of decoded points, in one pass over them. */
import { BLOCK, BLOCK_VALUES, sizeCode, SIZE_CODES } from './segment';

/** Points whose common extent gives the local spacing. */
const RUN = 32;
const RUNS_PER_BLOCK = BLOCK / RUN;
const scratch = new Float64Array(65536 / RUN + 1);

export function blockCount(points: number): number {
  return Math.ceil(points / BLOCK);
}

/**
 * Fill the blocks' bounds and stamp each vertex with its chunk and size code.
 *
 * Neighbours in Morton order are neighbours in space, so a run of them covers a patch of surface
 * whose area says how far its points lie apart.  `vertices` is a view of the chunk's points,
 * 6 uint16 each; `blocks` starts at the chunk's first block.
 */
export function finishChunk(
  vertices: Uint16Array,
  count: number,
  scale: readonly [number, number, number],
  chunk: number,
  blocks: Uint16Array,
): void {
  const runs = Math.ceil(count / RUN);
  const spacings = runs <= scratch.length ? scratch : new Float64Array(runs);
  measureRuns(vertices, count, scale, blocks, spacings);
  for (let run = 0; run < runs; run++) {
    const here = spacings[run]!;
    const before = run > 0 ? spacings[run - 1]! : here;
    const after = run + 1 < runs ? spacings[run + 1]! : here;
    // A run that jumps across a gap measures the gap; its neighbours know better.
    const spacing = Math.min(here, 1.5 * Math.min(before, after));
    const stamp = chunk * SIZE_CODES + sizeCode(spacing);
    const stop = Math.min(count, (run + 1) * RUN) * 6;
    for (let i = run * RUN * 6 + 5; i < stop; i += 6) vertices[i] = stamp;
  }
}

function measureRuns(
  vertices: Uint16Array,
  count: number,
  scale: readonly [number, number, number],
  blocks: Uint16Array,
  spacings: Float64Array,
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
    spacings[run] = spacing((hiX - loX) * scaleX, (hiY - loY) * scaleY, (hiZ - loZ) * scaleZ, n);
  }
}

/** Distance between `n` points spread over a patch with these extents: an area, or a line. */
function spacing(a: number, b: number, c: number, n: number): number {
  const longest = Math.max(a, b, c);
  const shortest = Math.min(a, b, c);
  const middle = a + b + c - longest - shortest;
  return Math.max(Math.sqrt((longest * middle) / n), longest / n, 1e-6);
}
