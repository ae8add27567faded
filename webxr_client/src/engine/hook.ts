/** `window.__pointbrush`: state for tests and benchmarks.  Nothing here changes labels. */
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
