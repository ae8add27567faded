/** Alignment of the sensors of the open recording, and its undo. */
import { computed } from '@preact/signals';
import { api } from '../net/rest';
import type { Job } from '../protocol/values';
import { isActive, notify, state } from '../store/state';
import { finished, sequencePath, succeeds } from './recordings/recordings';

const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

/** Whether mounts of the open recording are corrected. */
export const aligned = computed(() =>
  (state.sequence.value?.sensors ?? []).some(({ correction }) =>
    correction.some((value, i) => value !== IDENTITY[i]),
  ),
);

export const aligning = computed(() =>
  state.jobs.value.some(
    (job) => job.kind === 'alignment' && isActive(job) && job.sequence === state.sequence.value?.id,
  ),
);

/** Correct the mounts by surfaces that several sensors see, or restore the mounts of before. */
export async function alignSensors(undo = false): Promise<void> {
  const info = state.sequence.peek();
  if (!info || aligning.peek()) return;
  await succeeds(
    undo ? 'The mounts were not restored' : 'The sensors were not aligned',
    async () => {
      const id = crypto.randomUUID();
      const path = `${sequencePath(info.id)}/sensors/align`;
      const { message } = await finished(id, api<Job>('POST', path, { id, undo }));
      const action = { label: 'Undo', run: () => void alignSensors(true) };
      if (undo) notify('success', 'Alignment undone', message);
      else notify('success', 'Sensors aligned', message, action);
    },
  );
}
