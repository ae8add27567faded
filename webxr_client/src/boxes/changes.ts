/** Changes of boxes: each is one edit of the server's, and shows before it has answered. */
import { batch, signal } from '@preact/signals';
import { Matrix4 } from 'three';
import { attempt, openPath } from '../engine/recordings/recordings';
import { api } from '../net/rest';
import type { Job } from '../protocol/messages';
import type { BoxEdit, BoxFit, FittedBoxes, Placement } from '../protocol/values';
import { actions } from '../store/actions';
import {
  chosenBox,
  expectChange,
  NONE,
  picked,
  takeBoxes,
  type Triple,
  type BoxPatch,
  type BoxPose,
  type ObjectBox,
} from '../store/boxes';
import { canEdit, isActive, notify, state } from '../store/state';
import { follow } from '../store/watch';
import {
  between,
  carried,
  drawnAround,
  drawnPose,
  patchOf,
  SHORTEST,
  shapeIn,
  stretched,
  turned,
  type Shape,
} from './shape';

/** A shape that is dragged and not yet an edit. */
export interface Draft {
  readonly id: number;
  readonly frame: number;
  readonly before: Shape;
  readonly shape: Shape;
}

export const draft = signal<Draft | null>(null);

/** The shape of a box in a frame, as it is being dragged. */
export function shownIn(box: ObjectBox, frame: number): Shape | null {
  const now = draft.value;
  return now?.id === box.id && now.frame === frame ? now.shape : shapeIn(box, frame);
}

/** Drag a box's shape in a frame; `commitDraft` makes an edit of it. */
export function dragTo(box: ObjectBox, frame: number, shape: Shape): void {
  const now = draft.peek();
  const same = now?.id === box.id && now.frame === frame;
  const before = same ? now.before : shapeIn(box, frame);
  if (before && canEdit.peek()) draft.value = { id: box.id, frame, before, shape };
}

/** One edit of all that was dragged. */
export function commitDraft(): void {
  const now = draft.peek();
  const box = chosenBox.peek();
  if (!now || box?.id !== now.id) {
    draft.value = null;
    return;
  }
  batch(() => {
    draft.value = null;
    if (now.shape !== now.before) {
      void changeBox(box.id, patchOf(box, now.frame, now.before, now.shape));
    }
  });
}

export function dropDraft(): boolean {
  const hadDraft = draft.peek() !== null;
  draft.value = null;
  return hadDraft;
}

function take({ box, revision }: BoxEdit): void {
  takeBoxes({ revision, boxes: [box], removed: [], whole: false });
}

/** Changes go one after another, as they were made. */
let last: Promise<unknown> = Promise.resolve();

function inOrder<T>(work: () => Promise<T>): Promise<T> {
  const next = last.then(work, work);
  last = next.catch(() => undefined);
  return next;
}

export async function changeBox(id: number, patch: BoxPatch): Promise<void> {
  const answered = expectChange(id, patch);
  const edit = crypto.randomUUID();
  await attempt('The box was not changed', async () => {
    take(await inOrder(() => api<BoxEdit>('PATCH', openPath(`boxes/${id}`), { ...patch, edit })));
  });
  answered();
}

export async function removeBox({ id }: ObjectBox): Promise<void> {
  const answered = expectChange(id, null);
  await attempt('The box was not deleted', async () => {
    const { revision } = await inOrder(() => api<BoxEdit>('DELETE', openPath(`boxes/${id}`)));
    takeBoxes({ revision, boxes: [], removed: [id], whole: false });
  });
  answered();
}

/** A box of the active label in the frame on screen, and choose it. */
export async function addBox({ size, centre, quaternion }: Shape): Promise<void> {
  const label = state.activeLabel.peek();
  const pose = drawnPose({ centre, quaternion });
  const known = chosenBox.peek();
  const frame = state.shown.peek().frame;
  // A label with a box gets a pose in this frame: one object has one box.
  if (known) return changeBox(known.id, { size, poses: { [frame]: pose } });
  await attempt('The box was not made', async () => {
    const edit = crypto.randomUUID();
    const made = { label, size, poses: { [frame]: pose }, provenance: 'drawn' };
    const answer = await inOrder(() => api<BoxEdit>('POST', openPath('boxes'), { ...made, edit }));
    take(answer);
    picked.value = answer.box.id;
  });
}

/** Choose a box, and its label with it. */
export function chooseBox({ id, label }: ObjectBox): void {
  if (state.activeLabel.peek() !== label) actions.labels.selectLabel(label);
  picked.value = id;
}

export function leaveBox(): boolean {
  if (dropDraft()) return true;
  if (chosenBox.peek() === null) return false;
  picked.value = NONE;
  return true;
}

// ── work of the server ─────────────────────────────────────────────────────────────────────────

/** Most skipped labels that a message lists. */
const MAX_LISTED_LABELS = 3;

/** Fit boxes to labelled points; drawn poses stay, unless they are to be fitted too. */
export function fitBoxes({ labels, category, frames, redraw = false }: BoxFit): Promise<void> {
  return attempt('No box was fitted', async () => {
    const body = { labels, category, frames, redraw };
    const { id } = await api<{ id: string }>('POST', openPath('boxes/fit'), body);
    ended(
      (job) => job.id === id,
      (job) => {
        if (job.state === 'done')
          void attempt('The fitted boxes did not load', () => notifyFit(id));
      },
    );
  });
}

async function notifyFit(id: string): Promise<void> {
  const { result } = await api<{ result: FittedBoxes }>('GET', `jobs/${id}`);
  const names = new Map(state.palette.peek().map((label) => [String(label.id), label.name]));
  const skipped = Object.entries(result.skipped).map(
    ([label, why]) => `${names.get(label) ?? label}: ${why}`,
  );
  const count = result.fitted.length;
  const title = count === 1 ? '1 box fitted' : `${count === 0 ? 'No' : count} boxes fitted`;
  notify(count > 0 ? 'success' : 'info', title, skipped.slice(0, MAX_LISTED_LABELS).join(' · '));
}

/** Run `done` with a job of the open recording once it has ended; nothing once that is closed. */
function ended(which: (job: Job) => boolean, done: (job: Job) => void): void {
  const sequence = state.sequence.peek()?.id;
  let over = false;
  const stop = follow(() => {
    const job = state.jobs.value.find(which);
    const gone = state.sequence.value?.id !== sequence;
    if (over || (!gone && (!job || isActive(job)))) return;
    over = true;
    queueMicrotask(() => {
      stop();
      if (!gone && job) done(job);
    });
  });
}

/** Fit a box to the points of the active label in the frame on screen. */
export function boxFromPoints(): Promise<void> {
  const { frame } = state.shown.peek();
  const labels = [state.activeLabel.peek()];
  return fitBoxes({ labels, category: null, frames: `${frame}:${frame + 1}`, redraw: true });
}

/** Give the points in the chosen box its label, in the frame on screen or in all of the box's. */
export function pointsFromBox(everywhere: boolean): Promise<void> {
  const box = chosenBox.peek();
  const { frame } = state.shown.peek();
  if (!box) return Promise.resolve();
  return attempt('The points were not labelled', async () => {
    const frames = everywhere ? null : `${frame}:${frame + 1}`;
    await inOrder(() => api('POST', openPath(`boxes/${box.id}/points`), frames ? { frames } : {}));
    notify('success', 'The points in the box are labelled');
  });
}

/** Carry the active label through all frames, and fit its box once that has ended. */
export function trackAndFit(): void {
  const label = state.activeLabel.peek();
  const start = state.frame.peek();
  const stop = (state.sequence.peek()?.frames ?? 1) - 1;
  const fit = (): void => void fitBoxes({ labels: [label], category: null, frames: null });
  const run = (to: number): void => actions.tracking.track({ labels: [label], start, stop: to });
  const ways = [stop, 0].filter((to) => to !== start);
  if (ways.length === 0) fit();
  else afterTracking(ways, run, fit);
}

/** Run after run, each once the one before it has ended; then `done`. */
function afterTracking(ways: readonly number[], run: (to: number) => void, done: () => void): void {
  const [to, ...rest] = ways;
  if (to === undefined) {
    done();
    return;
  }
  const known = new Set(state.jobs.peek().map(({ id }) => id));
  ended(
    ({ id, kind }) => kind === 'tracking' && !known.has(id),
    (job) => {
      if (job.state === 'done') afterTracking(rest, run, done);
    },
  );
  run(to);
}

// ── other frames ───────────────────────────────────────────────────────────────────────────────

function matrixOf(rows: readonly number[]): Matrix4 {
  return new Matrix4().set(...(rows as Parameters<Matrix4['set']>));
}

/** Transforms into `frame` of frames around it; source coordinates. */
async function placements(frame: number, before: number, after: number): Promise<Placement[]> {
  const path = openPath(`frames/${frame}/placements?before=${before}&after=${after}`);
  return api<Placement[]>('GET', path);
}

/** The pose that a box has in `from`, in `to`: along with its label's track, or with the ground. */
async function poseIn(box: ObjectBox, from: number, to: number): Promise<BoxPose> {
  const pose = box.poses[from]!;
  const [before, after] = [Math.max(0, to - from), Math.max(0, from - to)];
  const placement = (await placements(to, before, after)).find(({ frame }) => frame === from);
  const track = placement?.moving.find(({ label }) => label === box.label);
  const rows = (track ?? placement)?.T_shown_frame;
  return drawnPose(rows ? carried(pose, matrixOf(rows)) : pose, pose);
}

/** Copy the chosen box's pose to the next frame (1), or the one before (−1), and go there. */
export function copyToFrame(step: 1 | -1): Promise<void> {
  const box = chosenBox.peek();
  const from = state.frame.peek();
  const to = from + step;
  const frames = state.sequence.peek()?.frames ?? 0;
  if (!box || !(from in box.poses) || to < 0 || to >= frames) return Promise.resolve();
  return attempt('The box was not copied', async () => {
    const pose = await poseIn(box, from, to);
    actions.time.step(step);
    await changeBox(box.id, { poses: { [to]: pose } });
  });
}

/** Bring the chosen box to the frame on screen from the nearest one that has it. */
export function copyToShownFrame(): Promise<void> {
  const box = chosenBox.peek();
  const to = state.frame.peek();
  const frames = Object.keys(box?.poses ?? {}).map(Number);
  const [from] = frames.sort((a, b) => Math.abs(a - to) - Math.abs(b - to));
  if (!box || from === undefined) return Promise.resolve();
  return attempt('The box was not copied', async () => {
    await changeBox(box.id, { poses: { [to]: await poseIn(box, from, to) } });
  });
}

/** Give the chosen box another edge, metres: about its middle, its bottom stays. */
export function patchSize(box: ObjectBox, axis: 0 | 1 | 2, metres: number): void {
  const { frame } = state.shown.peek();
  const shape = shapeIn(box, frame);
  if (!(metres >= SHORTEST)) return;
  const size = box.size.map((edge, k) => (k === axis ? metres : edge)) as unknown as Triple;
  if (!shape || axis !== 2) {
    void changeBox(box.id, { size });
    return;
  }
  const by: Triple = [0, 0, metres - box.size[2]];
  void changeBox(box.id, patchOf(box, frame, shape, stretched(shape, [0, 0, 1], by)));
}

/** Turn the chosen box by 180° in all frames; its heading then counts as known. */
export async function turnRound(): Promise<void> {
  const box = chosenBox.peek();
  if (!box) return;
  const poses: Record<string, BoxPose> = {};
  for (const [frame, pose] of Object.entries(box.poses)) {
    const { quaternion } = turned({ ...pose, size: box.size }, 2, Math.PI);
    poses[frame] = { ...pose, quaternion };
  }
  await changeBox(box.id, { poses, heading_known: true });
}

/** Confidence of poses between drawn ones. */
const INTERPOLATED = 0.7;

/** Lay poses on the way between the two drawn ones around the frame on screen, fixed to the ground. */
export function interpolate(): Promise<void> {
  const box = chosenBox.peek();
  const around = box && drawnAround(box, state.frame.peek());
  if (!box || !around) {
    notify(
      'info',
      'Draw the box in two frames first',
      'Interpolation fills the frames between them.',
    );
    return Promise.resolve();
  }
  return attempt('Nothing was interpolated', async () => {
    const [first, end] = around;
    const found = await placements(first, 0, end - first);
    const into = new Map(found.map((one) => [one.frame, matrixOf(one.T_shown_frame)]));
    const still = new Matrix4();
    const a = box.poses[first]!;
    const b = carried(box.poses[end]!, into.get(end) ?? still);
    const poses: Record<string, BoxPose> = {};
    for (let frame = first + 1; frame < end; frame++) {
      const back = (into.get(frame) ?? still).clone().invert();
      const placed = carried(between(a, b, (frame - first) / (end - first)), back);
      const attributes = box.poses[frame]?.attributes ?? {};
      poses[frame] = { ...placed, provenance: 'fitted', confidence: INTERPOLATED, attributes };
    }
    if (Object.keys(poses).length > 0) await changeBox(box.id, { poses });
  });
}
