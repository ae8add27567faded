/** Signals watched without reading them: what runs is made once, and again with every news. */
import { effect, untracked, type ReadonlySignal } from '@preact/signals';

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
    effect(() => {
      read(signal);
      untracked(changed);
    }),
  );
  return () => {
    for (const stop of stops) stop();
  };
}
