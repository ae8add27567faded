/** Pictures of a replay, as numbered PNG files in a zip. */
import { zipSync } from 'three/examples/jsm/libs/fflate.module.js';
import { saveBlob } from '../net/files';
import { duration, plays, type Replay, speed, time } from './replay';

/** Pictures of a second as it is replayed, and most of a file. */
const [RATE, MOST] = [10, 1200];

/** Save pictures of the whole replay at its speed; `progress` gets the done share, 0..1. */
export async function savePictures(
  replay: Replay,
  progress: (share: number) => void,
): Promise<void> {
  plays.value = false;
  const files: Record<string, Uint8Array> = {};
  const step = Math.max((1000 * speed.peek()) / RATE, duration.peek() / MOST);
  for (let t = 0, k = 0; t <= duration.peek(); t += step, k++) {
    time.value = t;
    files[`${String(k).padStart(5, '0')}.png`] = await drawn(replay);
    progress(t / duration.peek());
  }
  // A PNG is compressed already.
  const zip = zipSync(files, { level: 0 }) as Uint8Array<ArrayBuffer>;
  saveBlob(`${replay.name}.zip`, new Blob([zip]));
}

/** Return the canvas as a PNG once it shows the current time. */
async function drawn(replay: Replay): Promise<Uint8Array> {
  const { viewer } = replay.engine;
  const blob = await new Promise<Blob | null>((resolve) => {
    let waits = 2;
    const stop = viewer.ticks.add(() => {
      viewer.invalidate();
      // The time is taken in before the first of two pictures.
      if (!replay.settled || waits-- > 0) return;
      stop();
      // The browser empties the canvas once it was shown: it is read just after it was drawn.
      queueMicrotask(() => viewer.canvas.toBlob(resolve));
    });
  });
  if (!blob) throw new Error('The browser made no picture of the canvas.');
  return new Uint8Array(await blob.arrayBuffer());
}
