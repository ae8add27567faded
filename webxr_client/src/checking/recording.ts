/** The recording in which a headset is checked. */
import { computed } from '@preact/signals';
import { actions } from '../store/actions';
import { attempt } from '../engine/recordings/recordings';
import { api } from '../net/rest';
import { canEdit, state } from '../store/state';
import { follow } from '../store/watch';

/** Labels that are needed to switch between them. */
const LABELS = 2;

/** Points are on screen, and there is something to paint with. */
export const ready = computed(
  () => state.shown.value.total > 0 && (!canEdit.value || state.palette.value.length >= LABELS),
);

/** Open the server's scratch recording; viewers, without edits, open the first recording. */
export function openRecording(): void {
  const stop = follow(() => {
    const sound = state.sequences.value?.filter(({ damaged }) => damaged === null);
    if (!sound || state.me.value === null) return;
    queueMicrotask(() => {
      stop();
      const [first] = sound;
      if (canEdit.peek()) void openScratch();
      else if (first) actions.recordings.openSequence(first.id);
    });
  });
}

async function openScratch(): Promise<void> {
  await attempt('The recording for the check was not made', async () => {
    const { sequence } = await api<{ sequence: string }>('POST', 'headset-checks');
    actions.recordings.openSequence(sequence);
  });
}
