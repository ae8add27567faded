/** History of changes, with author and time; a line leads to its frame. */
import type { PastEdit } from '../protocol/values';
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { actions } from '../store/actions';
import { labelIn } from '../engine/time';
import { state } from '../store/state';
import { plural } from '../common/format';
import { PopoverButton } from './parts/popover';

export const historyOpen = signal(false);

/** Kinds of edits that change the palette without changing frames. */
const PALETTE: ReadonlySet<string> = new Set(['label', 'undo', 'redo']);

export function HistoryButton() {
  return (
    <PopoverButton
      open={historyOpen}
      icon="history"
      tip="History of edits"
      label="History"
      class="history-menu wide"
    >
      <HistoryMenu />
    </PopoverButton>
  );
}

function HistoryMenu() {
  const { undo, redo } = state;
  // Each edit changes the next undo: reload the history then.
  useEffect(() => {
    void actions.history.loadHistory();
  }, [undo.value, redo.value]);
  const edits = state.history.value;
  return (
    <>
      <h2>History</h2>
      {edits.length === 0 && <p class="soft empty">No edits yet.</p>}
      <ol>
        {edits.map((edit) => (
          <li key={edit.id}>
            <HistoryLine edit={edit} />
          </li>
        ))}
      </ol>
    </>
  );
}

function HistoryLine({ edit }: { edit: PastEdit }) {
  const frame = edit.frames[0];
  return (
    <button
      type="button"
      class="menu-item"
      disabled={frame === undefined}
      data-undone={edit.undone || undefined}
      data-tip={frame === undefined ? undefined : `Go to frame ${frame}`}
      onClick={() => {
        if (frame === undefined) return;
        actions.time.seek(frame);
        const label = labelIn(edit.summary);
        if (label !== null) actions.view.goToObject(label, frame);
      }}
    >
      <span class="lines grow">
        {edit.summary || edit.kind}
        <span class="soft">
          {edit.author} · {when(edit.time)}
          {edit.undone && ' · undone'}
        </span>
      </span>
      <span class="end">
        {edit.points > 0 && plural(edit.points, 'point')}
        <br />
        {place(edit)}
      </span>
    </button>
  );
}

function place({ frames, kind }: PastEdit): string {
  if (frames.length === 0) return PALETTE.has(kind) ? 'palette' : 'no change';
  const [first, last] = [Math.min(...frames), Math.max(...frames)];
  return first === last ? `frame ${first}` : `frames ${first} – ${last}`;
}

/** The time of day for today's edits, the date before it for older ones. */
function when(iso: string): string {
  const time = new Date(iso);
  const clock = time.toLocaleTimeString([], { hour: '2-digit', minute: '2-digit' });
  const today = time.toDateString() === new Date().toDateString();
  return today ? clock : `${time.toLocaleDateString()} ${clock}`;
}
