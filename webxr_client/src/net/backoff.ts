/** Waiting times between tries to reconnect: doubling, with jitter so that viewers spread out. */

const FIRST_MS = 250;
const LONGEST_MS = 8000;

export class Backoff {
  private tries = 0;

  constructor(private readonly random: () => number = Math.random) {}

  next(): number {
    const wait = Math.min(LONGEST_MS, FIRST_MS * 2 ** this.tries);
    this.tries += 1;
    return wait * (0.75 + 0.5 * this.random());
  }

  reset(): void {
    this.tries = 0;
  }
}
