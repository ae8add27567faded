/** A stretch of frames that a label is doubtful in: judged, or tracked again, in one press. */
import { computed, type ReadonlySignal } from '@preact/signals';
import { actions, type Actions } from '../actions';
import { api } from '../net/rest';
import { cellKind, wantsLook } from '../panels/timeline-layout';
import { notify, state, type TimelineRow } from '../state';
import { attempt, sequencePath } from './recordings';

export interface Stretch {
  readonly labels: readonly number[];
  /** Its first and last frame. */
  readonly start: number;
  readonly stop: number;
}

type Rows = ReadonlyMap<number, TimelineRow>;

/** The doubtful frames round `frame`, or beside it where it is sure; null when there are none. */
export function stretchAt(rows: Rows, frame: number, frames: number): Stretch | null {
  for (const seed of [frame, frame + 1, frame - 1]) {
    if (seed < 0 || seed >= frames) continue;
    const labels = [...rows.keys()].filter((id) => doubtful(rows, id, seed));
    if (labels.length === 0) continue;
    const any = (at: number): boolean => labels.some((id) => doubtful(rows, id, at));
    let [start, stop] = [seed, seed];
    while (start > 0 && any(start - 1)) start -= 1;
    while (stop < frames - 1 && any(stop + 1)) stop += 1;
    return { labels, start, stop };
  }
  return null;
}

function doubtful(rows: Rows, id: number, frame: number): boolean {
  const row = rows.get(id);
  return row !== undefined && wantsLook(cellKind(row, frame));
}

export interface Again {
  readonly labels: readonly number[];
  readonly start: number;
  readonly stop: number;
}

/** The run that finds a stretch anew: from the sure frame before it, else from the one behind. */
export function againOver({ labels, start, stop }: Stretch, rows: Rows): Again | null {
  for (const [from, to] of [[start - 1, stop], [stop + 1, start]] as const) {
    const there = labels.filter(
      (id) => (rows.get(id)?.points[from] ?? 0) > 0 && !doubtful(rows, id, from),
    );
    if (there.length > 0) return { labels: there, start: from, stop: to };
  } // prettier-ignore
  return null;
}

/** The stretch at the frame at which time stands. */
export const stretch: ReadonlySignal<Stretch | null> = computed(() => {
  const { rows } = state.timeline.value;
  if (state.playing.value || rows.size === 0) return null;
  return stretchAt(rows, state.frame.value, state.sequence.value?.frames ?? 0);
});

async function judge(what: 'accept' | 'clear', failed: string): Promise<void> {
  const found = stretch.peek();
  const { id } = state.sequence.peek() ?? {};
  if (!found || id === undefined) return;
  const { labels, start, stop } = found;
  await attempt(failed, async () => {
    await api('POST', `${sequencePath(id)}/${what}`, { labels, start, stop });
  });
}

function trackAgain(): void {
  const found = stretch.peek();
  if (!found) return;
  const run = againOver(found, state.timeline.peek().rows);
  if (run) actions.track({ ...run, method: 'auto', overwrite: 'tracked', continue_lost: true });
  else notify('info', 'Nothing to track from', 'Paint the object in a frame beside the stretch.');
}

export const stretchActions: Pick<Actions, 'acceptStretch' | 'clearStretch' | 'trackStretch'> = {
  acceptStretch: () => judge('accept', 'The stretch was not accepted'),
  clearStretch: () => judge('clear', 'The stretch was not cleared'),
  trackStretch: trackAgain,
};
