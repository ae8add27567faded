/** Effects that run whenever signals change.  Setters run them, so that they never throw into them. */
import { effect, untracked, type ReadonlySignal } from '@preact/signals';
import { tellFailure } from './listeners';

/** Run `run` now and whenever a signal that it reads changes; the result stops it. */
export function follow(run: () => void): () => void {
  return effect(() => {
    try {
      run();
    } catch (error) {
      tellFailure(error);
    }
  });
}

/** An effect depends on what it reads. */
function read(signal: ReadonlySignal<unknown>): unknown {
  return signal.value;
}

/** Run `changed` now and whenever one of the signals has a new value; the result stops it. */
export function watch(
  signals: readonly ReadonlySignal<unknown>[],
  changed: () => void,
): () => void {
  const stops = signals.map((signal) =>
    follow(() => {
      read(signal);
      untracked(changed);
    }),
  );
  return () => {
    for (const stop of stops) stop();
  };
}
