/** Benchmark: take in frame after frame as fast as they come, each uploaded to the GPU whole. */
import type { CloudFrame } from '../cloud/frame';
import { state } from '../state';
import type { Engine } from './engine';

export interface ReplayResult {
  readonly seconds: number;
  readonly frames: number;
  readonly points: number;
  readonly bytes: number;
  /** Milliseconds in the worker, and on the page's own thread, for each frame. */
  readonly decodeMs: number;
  readonly uploadMs: number;
}

/**
 * Seek from frame to frame for some seconds.  Every frame is forgotten once it is on the GPU, so
 * that the server sends it again.
 */
export function replay(engine: Engine, seconds: number): Promise<ReplayResult> {
  const { playback, viewer, link } = engine;
  const frames = state.sequence.peek()?.frames ?? 1;
  const before = { ...playback.counters };
  const started = performance.now();
  let done = 0;
  let uploadMs = 0;
  return new Promise((resolve) => {
    const next = (frame: CloudFrame): void => {
      const began = performance.now();
      viewer.show(frame);
      uploadMs += performance.now() - began;
      done += 1;
      playback.forget([frame]);
      link.send({ type: 'seek', frame: (frame.index + 1) % frames });
      const elapsed = (performance.now() - started) / 1000;
      if (elapsed < seconds) return;
      stop();
      const { points, bytes, decodeMs } = playback.counters;
      resolve({
        seconds: elapsed,
        frames: done,
        points: points - before.points,
        bytes: bytes - before.bytes,
        decodeMs: (decodeMs - before.decodeMs) / done,
        uploadMs: uploadMs / done,
      });
    };
    const stop = playback.completed.add(next);
    playback.forget([...playback.store.all()]);
    link.send({ type: 'seek', frame: 0 });
  });
}
