/** The recording in which a headset is checked: the sample, or the first one, with two labels. */
import { computed } from '@preact/signals';
import { actions } from '../store/actions';
import { attempt, sequencePath } from '../engine/recordings';
import { firstOf } from '../net/early';
import { api } from '../net/rest';
import type { Label } from '../protocol/messages';
import { canEdit, state } from '../store/state';
import { follow } from '../store/watch';

/** Id of the sample recording. */
const SAMPLE = 'juggling';
/** Labels that are needed to switch between them. */
const LABELS = 2;

/** Points are on screen, and there is something to paint with. */
export const ready = computed(
  () => state.shown.value.total > 0 && (!canEdit.value || state.palette.value.length >= LABELS),
);

/** Open a recording unless the address names one. */
export function openRecording(): void {
  const stop = follow(() => {
    const sound = state.sequences.value?.filter(({ damaged }) => damaged === null);
    if (!sound || sound.length === 0) return;
    queueMicrotask(() => {
      stop();
      if (firstOf(sound) !== null) return;
      actions.openSequence((sound.find(({ id }) => id === SAMPLE) ?? sound[0]!).id);
    });
  });
}

/** Make the labels that are missing, once there is something to paint. */
export function makeLabels(): void {
  const stop = follow(() => {
    const { id } = state.sequence.value ?? {};
    const known = state.me.value !== null && canEdit.value;
    if (id === undefined || !known || state.shown.value.total === 0) return;
    queueMicrotask(() => {
      stop();
      void fill(id);
    });
  });
}

/** Points may come before the palette: the server is asked how many there are. */
async function fill(sequence: string): Promise<void> {
  await attempt('The labels to check with were not made', async () => {
    const labels = await api<Label[]>('GET', `${sequencePath(sequence)}/labels`);
    for (let i = labels.length; i < LABELS; i++) await actions.createLabel();
  });
}
