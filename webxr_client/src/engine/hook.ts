/** `window.__pointbrush`: state for tests and benchmarks.  Nothing here changes labels. */
import type { CloudFrame } from '../cloud/points/frame';
import { DELETED } from '../cloud/points/piece';
import { SCHEMA_HASH } from '../protocol/messages';
import { state } from '../store/state';
import type { Engine } from './engine';

export function installHook(engine: Engine): void {
  const { viewer, playback } = engine;
  const hook = {
    schema: SCHEMA_HASH,
    state,
    engine,
    /** Points on screen. */
    shown: () => ({ ...state.shown.peek(), drawn: viewer.drawn }),
    /** Label id → points of it in a cached frame, as shown; deleted points under −1. */
    labels: (index = state.shown.peek().frame): Record<string, number> => {
      const counts: Record<string, number> = {};
      const frame = playback.store.get(index);
      for (const piece of frame?.pieces ?? []) {
        for (let i = 0; i < piece.count; i++) {
          const label = frame!.labelOf(piece.first + i);
          const key = label === DELETED ? -1 : label;
          counts[key] = (counts[key] ?? 0) + 1;
        }
      }
      return counts;
    },
    /** The same counts, from the labels that were sent to the GPU. */
    drawnLabels: () => Object.fromEntries(viewer.countLabels()),
    counters: () => ({
      ...playback.counters,
      pictures: viewer.pictures,
      cachedFrames: playback.store.size,
      cachedBytes: playback.store.usedBytes,
    }),
    /** Milliseconds a picture: our own work, the draw calls, and the work postponed after them. */
    timing: () => {
      viewer.measure(false);
      return {
        work: viewer.workMs.recent(),
        draw: viewer.drawMs.recent(),
        after: viewer.afterwards.ms.recent(),
        interval: viewer.intervalMs.recent(),
      };
    },
    /** Restart the measurement of times. */
    resetTiming: () => viewer.measure(true),
    /** Look from `eye` to `target`, room coordinates. */
    look: (eye: [number, number, number], target: [number, number, number]) => {
      const { position } = viewer.camera;
      engine.camera.lookAt(position.clone().set(...eye), position.clone().set(...target), true);
      viewer.invalidate();
    },
    /** Place of a point (source coordinates) on the page, CSS pixels of the canvas. */
    project: (point: [number, number, number]): [number, number] => {
      const shift = state.sequence.peek()?.shift ?? [0, 0, 0];
      viewer.camera.updateMatrixWorld();
      const at = viewer.camera.position.clone();
      at.set(point[0] - shift[0], point[1] - shift[1], point[2] - shift[2]);
      at.applyMatrix4(viewer.room.matrixWorld).project(viewer.camera);
      const { clientWidth, clientHeight } = viewer.canvas;
      return [((at.x + 1) / 2) * clientWidth, ((1 - at.y) / 2) * clientHeight];
    },
    /** See `replay.ts`. */
    replay: (seconds: number) => replay(engine, seconds),
    setDrawing: (on: boolean) => {
      viewer.drawing = on;
    },
    /** Whether slow pictures make the server send fewer points. */
    setAdaptive: (on: boolean) => {
      engine.pacing.adaptive = on;
    },
  };
  Object.defineProperty(window, '__pointbrush', { value: Object.freeze(hook) });
}

/** Benchmark: take in frame after frame as fast as they come, each uploaded to the GPU whole. */
interface ReplayResult {
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
function replay(engine: Engine, seconds: number): Promise<ReplayResult> {
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
