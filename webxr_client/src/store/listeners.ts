/**
 * Listeners of every picture or message.  One that throws loses its own work only: the failure is
 * reported once, and the other listeners and the next picture continue.
 */
import { notify } from './state';

/** Most failures that are reported by one page. */
const MAX_REPORTS = 50;
const reported = new Set<string>();

/** Report a failure on the console and in a message, each kind of failure once. */
export function reportFailure(error: unknown): void {
  const text = error instanceof Error ? `${error.name}: ${error.message}` : String(error);
  if (reported.has(text) || reported.size >= MAX_REPORTS) return;
  reported.add(text);
  console.error('A part of the page failed; the rest continues.', error);
  try {
    notify(
      'error',
      'A part of the page failed',
      `The rest of the page continues and strokes are kept. Reload the page if a part is missing. (${text})`,
    );
  } catch (second) {
    // The message itself may fail.
    console.error(second);
  }
}

/** Functions of up to two arguments that are run in order, each guarded. */
export class Listeners<A = void, B = void> {
  private readonly list: ((a: A, b: B) => void)[] = [];

  /** Run `listener` from now on; the result stops it. */
  add(listener: (a: A, b: B) => void): () => void {
    this.list.push(listener);
    return () => {
      const at = this.list.indexOf(listener);
      if (at >= 0) this.list.splice(at, 1);
    };
  }

  run(a: A, b: B): void {
    const { list } = this;
    for (let i = 0; i < list.length;) {
      const listener = list[i]!;
      try {
        listener(a, b);
      } catch (error) {
        reportFailure(error);
      }
      // One that stopped itself has left its place to the next.
      if (list[i] === listener) i++;
    }
  }
}
