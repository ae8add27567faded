/** The palette and the timeline: what the server says, and what the user asks for. */
import type { Actions, LabelPatch } from '../actions';
import { suggestColor, suggestName } from '../panels/colors';
import { listed } from '../panels/palette-list';
import { api } from '../net/rest';
import type { Label, Labels, Timeline } from '../protocol/messages';
import { CELL_STATES, isStroke, state, type HistoryEntry, type TimelineRow } from '../state';
import { beginLabel } from './new-label';
import { attempt } from './recordings';

type LabelActions = Pick<
  Actions,
  | 'selectLabel'
  | 'selectNthLabel'
  | 'lastLabel'
  | 'createLabel'
  | 'newLabel'
  | 'updateLabel'
  | 'renameLabel'
  | 'recolorLabel'
  | 'toggleVisible'
  | 'toggleLock'
  | 'deleteLabel'
  | 'solo'
  | 'loadHistory'
>;

// ── the server's messages ──────────────────────────────────────────────────────────────────

export function takeLabels(message: Labels): void {
  state.palette.value = message.labels;
  state.counts.value = new Map(
    Object.entries(message.counts).map(([id, count]) => [Number(id), count]),
  );
  state.undo.value = message.undo;
  state.redo.value = message.redo;
  const active = state.activeLabel.peek();
  if (making === 0 && !message.labels.some((label) => label.id === active)) {
    state.activeLabel.value = message.labels[0]?.id ?? 0;
  }
  const solo = state.solo.peek();
  if (solo !== null && !message.labels.some((label) => label.id === solo)) state.solo.value = null;
}

export function takeTimeline(message: Timeline, frames: number): void {
  const rows = new Map<number, TimelineRow>(message.whole ? [] : state.timeline.peek().rows);
  for (const cell of message.cells) {
    let row = rows.get(cell.label);
    if (!row) rows.set(cell.label, (row = emptyRow(frames)));
    row.points[cell.frame] = cell.points;
    row.painted[cell.frame] = cell.painted;
    row.confidence[cell.frame] = cell.confidence ?? Number.NaN;
    row.state[cell.frame] = CELL_STATES.indexOf(cell.state ?? 'none');
  }
  state.timeline.value = { rows };
}

function emptyRow(frames: number): TimelineRow {
  return {
    points: new Uint32Array(frames),
    painted: new Uint32Array(frames),
    confidence: new Float32Array(frames).fill(Number.NaN),
    state: new Uint8Array(frames),
  };
}

// ── the user's requests ───────────────────────────────────────────────────────────────────

function base(): string {
  return `sequences/${encodeURIComponent(state.sequence.peek()?.id ?? '')}`;
}

function find(id: number): Label | undefined {
  return state.palette.peek().find((label) => label.id === id);
}

/** Show the change at once; the server's palette replaces it, also when it refuses. */
async function update(id: number, patch: LabelPatch): Promise<void> {
  const before = state.palette.peek();
  state.palette.value = before.map((label) => (label.id === id ? { ...label, ...patch } : label));
  await attempt('The label was not changed', async () => {
    try {
      await api('PATCH', `${base()}/labels/${id}`, patch);
    } catch (error) {
      state.palette.value = before;
      throw error;
    }
  });
}

/** Number of labels that are being made: until then nothing is painted with the one before. */
let making = 0;

async function create(name?: string, color?: string, category = ''): Promise<number> {
  const palette = state.palette.peek();
  const body = {
    name: name ?? suggestName(category, palette.map((label) => label.name)), // prettier-ignore
    color: color ?? suggestColor(palette.map((label) => label.color)),
    category,
    // Somebody else may be making a label at this moment.
    distinct: true,
  };
  const before = state.activeLabel.peek();
  state.activeLabel.value = 0;
  making += 1;
  let id = 0;
  await attempt('The label was not made', async () => {
    const label = await api<Label>('POST', `${base()}/labels`, body);
    id = label.id;
    if (!find(id)) state.palette.value = [...state.palette.peek(), label];
  });
  making -= 1;
  if (state.activeLabel.peek() === 0) state.activeLabel.value = id || before;
  return id;
}

/** The label that was active before. */
let last = 0;

function select(id: number): void {
  if (!find(id)) return;
  const active = state.activeLabel.peek();
  if (active !== id) last = active;
  state.activeLabel.value = id;
  if (!isStroke(state.tool.peek())) state.tool.value = 'paint';
}

async function history(): Promise<void> {
  state.history.value = await api<HistoryEntry[]>('GET', `${base()}/edits`);
}

export const labelActions: LabelActions = {
  selectLabel: select,
  selectNthLabel: (n) => {
    const label = listed.peek()[n - 1];
    if (label) select(label.id);
  },
  lastLabel: () => {
    if (!find(last)) return false;
    select(last);
    return true;
  },
  createLabel: create,
  newLabel: () => beginLabel(create),
  updateLabel: update,
  renameLabel: (id, name) => update(id, { name }),
  recolorLabel: (id, color) => update(id, { color }),
  toggleVisible: (id) => update(id, { visible: !find(id)?.visible }),
  toggleLock: (id) => update(id, { locked: !find(id)?.locked }),
  deleteLabel: (id) =>
    attempt('The label was not deleted', async () => {
      await api('DELETE', `${base()}/labels/${id}`);
    }),
  solo: (id) => {
    state.solo.value = state.solo.peek() === id ? null : id;
  },
  loadHistory: () => attempt('The history did not load', history),
};
