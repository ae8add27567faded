/** The floor: people point at it, and the server stands the recording on it. */
import type { PointerSample, Vec } from '../store/types';
import { signal, type ReadonlySignal } from '@preact/signals';
import type { ActionParts } from '../store/actions';
import { api } from '../net/rest';
import { canEdit, notify, state } from '../store/state';
import { watch } from '../store/watch';
import { attempt, sequencePath } from './recordings/recordings';

/** Places that level a floor: with one more the oldest goes. */
const MOST = 3;
/** Metres round the place pointed at that light up. */
export const FLOOR_SPOT = 0.15;

interface Ray {
  readonly origin: Vec;
  readonly direction: Vec;
}

/** Rays to the floor (source coordinates) since the tool was taken, all in one frame. */
let rays: readonly Ray[] = [];
let at = '';
const count = signal(0);

/** Places that the floor lies on by now. */
export const floorPlaces: ReadonlySignal<number> = count;

function keep(next: readonly Ray[], place: string): void {
  rays = next;
  at = place;
  count.value = next.length;
}

// Choosing the tool again clears the places.
watch([state.tool], () => {
  if (state.tool.peek() !== 'floor') keep([], '');
});

async function point({ origin, direction }: PointerSample): Promise<void> {
  const info = state.sequence.peek();
  const { frame } = state.shown.peek();
  if (!info || frame < 0) return;
  if (!canEdit.peek()) {
    notify('info', 'Your role is viewer', 'Ask for an annotator’s token to set the floor.');
    return;
  }
  const [x, y, z] = info.shift;
  const ray = { origin: [origin[0] + x, origin[1] + y, origin[2] + z], direction } as const;
  const place = `${info.identity}/${frame}`;
  const samples = [...(place === at ? rays : []), ray].slice(-MOST);
  await attempt('The floor was not set', async () => {
    await api('POST', `${sequencePath(info.id)}/floor`, { frame, samples });
    keep(samples, place);
    // At the desk, the row of the tool's options shows this; a message would cover the floor.
    if (state.xr.peek().session !== 'running') return;
    const more =
      samples.length < MOST ? 'Point at a second place far away to level the floor.' : '';
    notify('success', 'Floor set', more);
  });
}

/** One after the other: the last one counts all of them. */
let sending = Promise.resolve();

function pointAtFloor(sample: PointerSample): Promise<void> {
  sending = sending.then(() => point(sample));
  return sending;
}

async function resetFloor(): Promise<void> {
  const info = state.sequence.peek();
  if (!info) return;
  await attempt('The floor was not set', async () => {
    await api('DELETE', `${sequencePath(info.id)}/floor`);
    keep([], '');
    notify('success', 'Floor reset to the import');
  });
}

export const floorActions = {
  view: {
    pointAtFloor,
    resetFloor,
  },
} satisfies ActionParts;
