/** The palette and the timeline: messages of the server, and requests of the user. */
import { signal } from '@preact/signals';
import { type ActionParts, actions } from '../../store/actions';
import { api } from '../../net/rest';
import { suggestColor, suggestName } from '../../common/colors';
import { labelColours } from '../../store/safe-colours';
import { listed } from '../../store/palette-list';
import { unpackF32, unpackU16, unpackU32 } from '../../protocol/codec';
import type { Label, Labels, Timeline } from '../../protocol/messages';
import type { PastEdit, Split } from '../../protocol/values';
import { canEdit, isStroke, notify, state, type TimelineRow } from '../../store/state';
import { attempt, openPath, succeeds } from '../recordings/recordings';

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
  const labels = unpackU16(message.labels);
  const points = unpackU32(message.points);
  const painted = unpackU32(message.painted);
  const confidence = unpackF32(message.confidence);
  unpackU32(message.frames).forEach((frame, i) => {
    let row = rows.get(labels[i]!);
    if (!row) rows.set(labels[i]!, (row = emptyRow(frames)));
    row.points[frame] = points[i]!;
    row.painted[frame] = painted[i]!;
    row.confidence[frame] = confidence[i]!;
    row.state[frame] = message.states[i]!;
  });
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

function pathOf(label: number): string {
  return openPath(`labels/${label}`);
}

function find(id: number): Label | undefined {
  return state.palette.peek().find((label) => label.id === id);
}

/** Show a palette at once; the server's replaces it, also when it refuses the request. */
export async function showAtOnce(
  next: readonly Label[],
  failed: string,
  request: () => Promise<unknown>,
): Promise<void> {
  const before = state.palette.peek();
  state.palette.value = next;
  const done = await succeeds(failed, request);
  if (!done) state.palette.value = before;
}

function update(id: number, patch: Partial<Label>): Promise<void> {
  const next = state.palette
    .peek()
    .map((label) => (label.id === id ? { ...label, ...patch } : label));
  return showAtOnce(next, 'The label was not changed', () => api('PATCH', pathOf(id), patch));
}

/** Number of labels that are being created; meanwhile, no stroke paints the previous label. */
let making = 0;

/** A name and a colour that no label has. */
function suggestion(category: string): Pick<Label, 'name' | 'color'> {
  const palette = state.palette.peek();
  const names = palette.map(({ name }) => name);
  const colors = palette.map(({ color }) => color);
  return {
    name: suggestName(category, names),
    color: suggestColor(colors, labelColours.peek()),
  };
}

async function create(name?: string, color?: string, category = ''): Promise<number> {
  const free = suggestion(category);
  // Another person may be creating a label at the same time.
  const body = { name: name ?? free.name, color: color ?? free.color, category, distinct: true };
  const before = state.activeLabel.peek();
  state.activeLabel.value = 0;
  making += 1;
  let id = 0;
  await attempt('The label was not made', async () => {
    const label = await api<Label>('POST', openPath('labels'), body);
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
  const tool = state.tool.peek();
  // A label's box is chosen with it.
  if (!isStroke(tool) && tool !== 'boxes') state.tool.value = 'paint';
}

async function history(): Promise<void> {
  state.history.value = await api<PastEdit[]>('GET', openPath('edits'));
}

export const labelActions = {
  labels: {
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
    newLabel: beginLabel,
    updateLabel: update,
    renameLabel: (id, name) => update(id, { name }),
    recolorAll: async () => {
      const colours = labelColours.peek();
      const given: string[] = [];
      for (const { id, color, locked } of listed.peek()) {
        const next = colours[given.length] ?? suggestColor(given, colours);
        given.push(next);
        if (color !== next && !locked) await update(id, { color: next });
      }
    },
    recolorLabel: (id, color) => update(id, { color }),
    toggleVisible: (id) => update(id, { visible: !find(id)?.visible }),
    toggleLock: (id) => update(id, { locked: !find(id)?.locked }),
    deleteLabel: (id) => attempt('The label was not deleted', () => api('DELETE', pathOf(id))),
    solo: (id) => {
      state.solo.value = state.solo.peek() === id ? null : id;
    },
    mergeLabel: merge,
    splitLabel: split,
    clearLabels: (labels, from, to) =>
      attempt('The labels were not cleared', () => edit(from, 'clear', { labels, stop: to })),
    copyLabels: (labels, source, frame) =>
      attempt('The labels were not copied', () => edit(frame, 'copy', { labels, source })),
    acceptLabels: (labels, frame) =>
      attempt('The frame was not accepted', () => edit(frame, 'accept', { labels })),
  },
  history: {
    loadHistory: () => attempt('The history did not load', history),
  },
} satisfies ActionParts;

/** A label that the server creates while its name is typed. */
interface NewLabel {
  readonly name: string;
  readonly color: string;
  /** 0 until the server has made it. */
  readonly id: number;
}

/** The label that is being named, or null. */
export const newLabel = signal<NewLabel | null>(null);

let made: Promise<number> = Promise.resolve(0);

/** Show an editable name while the server creates the label. */
async function beginLabel(): Promise<void> {
  if (!canEdit.peek() || newLabel.peek()) return;
  const draft: NewLabel = { ...suggestion(''), id: 0 };
  newLabel.value = draft;
  made = create(draft.name, draft.color);
  const id = await made;
  if (newLabel.peek() === draft) newLabel.value = id === 0 ? null : { ...draft, id };
}

/** Take the name that was typed; null gives the label up. */
export async function finishLabel(name: string | null): Promise<void> {
  const draft = newLabel.peek();
  if (!draft) return;
  newLabel.value = null;
  const id = await made;
  if (id === 0) return;
  if (name === null) await actions.labels.deleteLabel(id);
  else if (name !== '' && name !== draft.name) await actions.labels.renameLabel(id, name);
}

/** Whether an entry of the palette is the label that is being named: its row is the field's. */
export function isNew(draft: NewLabel | null, label: NewLabel): boolean {
  if (draft === null) return false;
  if (draft.id !== 0) return label.id === draft.id;
  return label.name === draft.name && label.color === draft.color;
}

function nameOf(id: number): string {
  return find(id)?.name ?? 'the label';
}

function merge(id: number, into: number): Promise<void> {
  const [from, to] = [nameOf(id), nameOf(into)];
  return attempt('The labels were not merged', async () => {
    await api('POST', `${pathOf(into)}/merge`, { labels: [id] });
    state.activeLabel.value = into;
    notify('success', `“${from}” merged into “${to}”`, 'In all frames. Undo reverts it.');
  });
}

function split(id: number): Promise<void> {
  const frame = state.frame.peek();
  return attempt(`“${nameOf(id)}” was not split`, async () => {
    const { labels } = await api<Split>('POST', `${pathOf(id)}/split`, { frame });
    notify(
      'success',
      `“${nameOf(id)}” split into ${labels.length + 1} parts`,
      'The largest part keeps the name. Track the new labels from this frame.',
    );
  });
}

/** Request an edit of labels in a frame, or from this frame on. */
function edit(frame: number, what: string, body: unknown): Promise<unknown> {
  return api('POST', openPath(`frames/${frame}/${what}`), body);
}
