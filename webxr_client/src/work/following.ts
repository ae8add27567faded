/** Keeps the Work panel up to date with this person's edits, the open recording and others. */
import { state } from '../store/state';
import { follow, watch } from '../store/watch';
import { followCopies } from './copies';
import { arrive } from './places';
import { chosen, loadTasks } from './queue';
import { checks, forgetReview, loadStates, refreshReview } from './review';
import { openWork, shows, workOpen } from './store';

/** Interval of reloading tasks and states, because there are no messages of their changes. */
const RELOAD_MS = 20_000;
/** Debounce of the search for findings after edits. */
const PAUSE_MS = 1200;

/** Reload states and findings after changes of labels; clear them with another recording. */
function followEdits(): void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let shown = '';
  follow(() => {
    const id = state.sequence.value?.id ?? '';
    const wanted = [state.timeline.value, state.palette.value, shows('findings')];
    if (id !== shown) forgetReview();
    shown = id;
    clearTimeout(timer);
    if (!workOpen.value || !id || wanted.length === 0) return;
    timer = setTimeout(() => void refreshReview(), checks.peek() ? PAUSE_MS : 0);
  });
}

function reload(): void {
  const online = state.connection.peek().state === 'online';
  if (!online || !workOpen.peek() || !state.sequence.peek() || document.hidden) return;
  void loadTasks();
  void loadStates().catch(() => undefined);
}

export function followWork(): void {
  followEdits();
  followCopies();
  follow(arrive);
  watch([chosen], () => {
    if (chosen.peek() !== null) openWork('tasks');
  });
  follow(() => {
    if (workOpen.value && state.sequence.value) queueMicrotask(() => void loadTasks());
  });
  setInterval(reload, RELOAD_MS);
}
