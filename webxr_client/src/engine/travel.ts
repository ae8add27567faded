/** An undo or redo that changed another frame than the one on screen: the page goes there. */
import { actions } from '../actions';
import { api } from '../net/rest';
import { notify, state, type HistoryEntry } from '../state';
import { follow } from '../watch';
import { sequencePath } from './recordings';

/** An answer that takes longer is of no interest: one has gone on. */
const PATIENCE_MS = 5000;
/** Newest edits among which it is looked for. */
const RECENT = 20;
const WORDS = { undo: 'Undone', redo: 'Redone' } as const;

/** Once the edit is answered, go to what it changed, unless it is in sight. */
export function showTravel(type: 'undo' | 'redo', edit: string): void {
  const { id } = state.sequence.peek() ?? {};
  if (id === undefined) return;
  let waits = true;
  const stop = follow(() => {
    if (state.pending.value > 0 || !waits) return;
    waits = false;
    queueMicrotask(() => {
      stop();
      clearTimeout(timer);
      void find(id, edit).then((entry) => entry && go(type, entry));
    });
  });
  const timer = setTimeout(stop, PATIENCE_MS);
}

async function find(sequence: string, edit: string): Promise<HistoryEntry | null> {
  const path = `${sequencePath(sequence)}/edits?limit=${RECENT}`;
  // Nobody asked for the history: where it does not come one stays.
  const edits = await api<HistoryEntry[]>('GET', path).catch(() => []);
  return edits.find((entry) => entry.id === edit) ?? null;
}

/** Go to the nearest frame of an edit, and say so. */
function go(type: 'undo' | 'redo', { frames, summary }: HistoryEntry): void {
  const here = state.frame.peek();
  if (frames.length === 0 || frames.includes(here)) return;
  const away = (frame: number): number => Math.abs(frame - here);
  const frame = frames.reduce((best, other) => (away(other) < away(best) ? other : best));
  actions.pause();
  actions.seek(frame);
  const label = labelIn(summary);
  if (label !== null) actions.goToObject(label, frame);
  notify('info', `${WORDS[type]} in frame ${frame}`, summary);
}

/** The label that a summary names, or null. */
export function labelIn(summary: string): number | null {
  const named = state.palette.peek().filter(({ name }) => summary.includes(name));
  // Of "pin" and "pin 1" the longer one is meant.
  const [longest] = named.sort((a, b) => b.name.length - a.name.length);
  return longest?.id ?? null;
}
