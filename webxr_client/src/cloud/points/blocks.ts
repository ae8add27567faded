/** Bounds of runs of neighbouring points, so that picking and painting test few of them. */

/** Points per block. */
export const BLOCK = 256;
/** A block's bounds: lo x, y, z then hi x, y, z, quantised like its points. */
export const BLOCK_VALUES = 6;

/** The bounds of every block of a chunk's points, 6 uint16 each. */
export function boundBlocks(words: Uint16Array, count: number): Uint16Array {
  const blocks = new Uint16Array(Math.ceil(count / BLOCK) * BLOCK_VALUES);
  for (let block = 0, first = 0; first < count; block += BLOCK_VALUES, first += BLOCK) {
    const stop = Math.min(count, first + BLOCK) * 6;
    let loX = 65535, loY = 65535, loZ = 65535, hiX = 0, hiY = 0, hiZ = 0; // prettier-ignore
    for (let i = first * 6; i < stop; i += 6) {
      const x = words[i]!;
      const y = words[i + 1]!;
      const z = words[i + 2]!;
      if (x < loX) loX = x;
      if (x > hiX) hiX = x;
      if (y < loY) loY = y;
      if (y > hiY) hiY = y;
      if (z < loZ) loZ = z;
      if (z > hiZ) hiZ = z;
    }
    blocks[block] = loX;
    blocks[block + 1] = loY;
    blocks[block + 2] = loZ;
    blocks[block + 3] = hiX;
    blocks[block + 4] = hiY;
    blocks[block + 5] = hiZ;
  }
  return blocks;
}
