/** The points that a stroke has met so far, each once, with the points that it changes in order. */

const LEAST = 1024;
/** Spreads numbers that follow each other (Knuth's multiplicative hash). */
const SPREAD = 0x9e3779b1;

export class Touched {
  /** Points that will change, sorted; the first `size` count. */
  numbers = new Uint32Array(LEAST);
  size = 0;
  /** Found since the last `settle`, in the order they were met. */
  private fresh = new Uint32Array(LEAST);
  private waiting = 0;
  /** Open addressing, at most half full: a number and one more, or 0. */
  private table = new Uint32Array(4 * LEAST);
  private known = 0;

  /** Whether a point is met for the first time. */
  meet(point: number): boolean {
    if (2 * this.known >= this.table.length) this.widen();
    if (!enter(this.table, point + 1)) return false;
    this.known += 1;
    return true;
  }

  /** A point just met will change. */
  take(point: number): void {
    if (this.waiting === this.fresh.length) this.fresh = grown(this.fresh, this.waiting + 1);
    this.fresh[this.waiting++] = point;
  }

  /** Every point that was met, in no order. */
  met(): Uint32Array<ArrayBuffer> {
    return this.table.filter((key) => key !== 0).map((key) => key - 1);
  }

  /** Sort newly taken points into the others; false when there were none. */
  settle(): boolean {
    if (this.waiting === 0) return false;
    const fresh = this.fresh.subarray(0, this.waiting).sort();
    let old = this.size - 1;
    this.size += this.waiting;
    this.waiting = 0;
    if (this.size > this.numbers.length) this.numbers = grown(this.numbers, this.size);
    const { numbers } = this;
    // From the end, so that nothing is written over that is still to be read.
    for (let to = this.size - 1, next = fresh.length - 1; next >= 0; to--) {
      const taken = old < 0 || numbers[old]! < fresh[next]!;
      numbers[to] = taken ? fresh[next--]! : numbers[old--]!;
    }
    return true;
  }

  private widen(): void {
    const table = new Uint32Array(4 * this.table.length);
    for (let i = 0; i < this.table.length; i++)
      if (this.table[i] !== 0) enter(table, this.table[i]!);
    this.table = table;
  }
}

/** Write a key into a table (a power of two long); false when it is there already. */
function enter(table: Uint32Array, key: number): boolean {
  const mask = table.length - 1;
  let at = (Math.imul(key, SPREAD) >>> 8) & mask;
  while (table[at] !== 0) {
    if (table[at] === key) return false;
    at = (at + 1) & mask;
  }
  table[at] = key;
  return true;
}

function grown(numbers: Uint32Array<ArrayBuffer>, least: number): Uint32Array<ArrayBuffer> {
  const wider = new Uint32Array(Math.max(least, 2 * numbers.length));
  wider.set(numbers);
  return wider;
}
