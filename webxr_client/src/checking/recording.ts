/** The recording in which a headset is checked: the sample, or the first one, with two labels. */
import { computed } from '@preact/signals';
import { actions } from '../actions';
import { firstOf } from '../net/early';
import { canEdit, state } from '../state';
import { follow } from '../watch';

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

/** Make the labels that are missing, once the recording's own have come. */
export function makeLabels(): void {
  let making = false;
  follow(() => {
    const missing = state.palette.value.length < LABELS;
    if (!missing || making || state.shown.value.total === 0 || !canEdit.value) return;
    making = true;
    queueMicrotask(() => {
      void actions.createLabel().finally(() => (making = false));
    });
  });
}
