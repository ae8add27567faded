/** The recording in which a headset is checked. */
import { computed } from '@preact/signals';
import { actions } from '../store/actions';
import { attempt } from '../engine/recordings/recordings';
import { api } from '../net/rest';
import { canEdit, state } from '../store/state';
import { until } from '../store/watch';

/** Labels that are needed to switch between them. */
const LABELS = 2;

/** Points are on screen, and there is something to paint with. */
export const ready = computed(
  () => state.shown.value.total > 0 && (!canEdit.value || state.palette.value.length >= LABELS),
);

/** Open the server's scratch recording; viewers, without edits, open the first recording. */
export async function openRecording(): Promise<void> {
  await until(() => state.sequences.value !== null && state.me.value !== null);
  const first = state.sequences.peek()?.find(({ damaged }) => damaged === null);
  if (canEdit.peek()) await openScratch();
  else if (first) actions.recordings.openSequence(first.id);
}

async function openScratch(): Promise<void> {
  await attempt('The recording for the check was not made', async () => {
    const { sequence } = await api<{ sequence: string }>('POST', 'headset-checks');
    actions.recordings.openSequence(sequence);
  });
}
