/** Boxes of the open recording: the server's boxes, under changes without an answer. */
import { computed, signal, type ReadonlySignal } from '@preact/signals';
import type { Box, BoxPose as Pose, Boxes } from '../protocol/messages';
import { state } from './state';

/** As the wire has it, and not to be changed in place. */
type Fixed<T> = { readonly [K in keyof T]: Fixed<T[K]> };

export type ObjectBox = Fixed<Box>;
/** Place of a box in a frame, source coordinates, from the box's axes: x forward, y left, z up. */
export type BoxPose = Fixed<Pose>;
export type Attributes = BoxPose['attributes'];
export type AttributeValue = Attributes[string];
export type Triple = BoxPose['centre'];
/** x, y, z, w. */
export type Quad = BoxPose['quaternion'];

type Merged = Readonly<Record<string, AttributeValue | null>>;

/** A change of a pose; attributes are merged, null removes. */
export type PosePatch = Partial<Omit<BoxPose, 'attributes'>> & { readonly attributes?: Merged };

/** A change as REST takes it: poses are merged by frame, attributes by name, null removes. */
export interface BoxPatch {
  readonly label?: number;
  readonly size?: Triple;
  readonly poses?: Readonly<Record<string, PosePatch | null>>;
  readonly attributes?: Merged;
  readonly heading_known?: boolean;
}

/** Changed boxes, and ids of removed boxes; `whole`: these are all boxes. */
type BoxUpdate = Omit<Fixed<Boxes>, 'type' | 'sequence'>;

interface Waiting {
  readonly id: number;
  readonly patch: BoxPatch | null;
}

/** The server's last boxes, and the revision of each box. */
const serverBoxes = signal<ReadonlyMap<number, ObjectBox>>(new Map());
const revisions = new Map<number, number>();
/** Changes on their way, oldest first; a null patch removes the box. */
const waiting = signal<readonly Waiting[]>([]);

/** Boxes by id, with the changes that are on their way. */
export const boxes: ReadonlySignal<ReadonlyMap<number, ObjectBox>> = computed(() => {
  if (waiting.value.length === 0) return serverBoxes.value;
  const now = new Map(serverBoxes.value);
  for (const { id, patch } of waiting.value) {
    const box = now.get(id);
    if (!box) continue;
    if (patch) now.set(id, patched(box, patch));
    else now.delete(id);
  }
  return now;
});

/** Labels that have a box in the frame on screen. */
export const boxedLabels: ReadonlySignal<ReadonlySet<number>> = computed(() => {
  const { frame } = state.shown.value;
  return new Set([...boxes.value.values()].filter(({ poses }) => frame in poses).map(({ label }) => label)); // prettier-ignore
});

/** Return a record with some members replaced, and null members removed. */
function merged<T>(
  before: Readonly<Record<string, T>>,
  changes: Readonly<Record<string, T | null>>,
): Record<string, T> {
  const all: Record<string, T | null> = { ...before, ...changes };
  return Object.fromEntries(
    Object.entries(all).filter((entry): entry is [string, T] => entry[1] !== null),
  );
}

/** A pose after a change; a new one is given whole. */
function patchedPose(pose: BoxPose | undefined, { attributes = {}, ...rest }: PosePatch): BoxPose {
  return { ...pose, ...rest, attributes: merged(pose?.attributes ?? {}, attributes) } as BoxPose;
}

export function patched(box: ObjectBox, { poses = {}, attributes, ...rest }: BoxPatch): ObjectBox {
  const moved = Object.entries(poses).map(
    ([frame, pose]) => [frame, pose && patchedPose(box.poses[frame], pose)] as const,
  );
  return {
    ...box,
    ...rest,
    poses: merged(box.poses, Object.fromEntries(moved)),
    attributes: merged(box.attributes, attributes ?? {}),
  };
}

/** Apply boxes from the server; ignore older states of a box. */
export function takeBoxes({ revision, boxes: some, removed, whole }: BoxUpdate): void {
  const now = new Map(whole ? [] : serverBoxes.peek());
  if (whole) revisions.clear();
  for (const box of some) {
    if (revision < (revisions.get(box.id) ?? 0)) continue;
    revisions.set(box.id, revision);
    now.set(box.id, box);
  }
  for (const id of removed) {
    if (revision < (revisions.get(id) ?? 0)) continue;
    revisions.set(id, revision);
    now.delete(id);
  }
  serverBoxes.value = now;
}

/** No recording is open. */
export function forgetBoxes(): void {
  revisions.clear();
  serverBoxes.value = new Map();
  waiting.value = [];
  picked.value = FOLLOWS;
}

/** Show a change that is on its way; the result ends that: it was answered, or refused. */
export function expectChange(id: number, patch: BoxPatch | null): () => void {
  const entry = { id, patch };
  waiting.value = [...waiting.peek(), entry];
  return () => {
    waiting.value = waiting.peek().filter((other) => other !== entry);
  };
}

// ── the chosen box ─────────────────────────────────────────────────────────────────────────────

/** The chosen box is the active label's. */
export const FOLLOWS = 0;
/** No box is chosen, until another label is. */
export const NONE = -1;
/** Id of the box that was chosen, or one of the two above. */
export const picked = signal(FOLLOWS);

/** The box that is worked on: one that was picked of the active label's, else the label's in the frame. */
export const chosenBox: ReadonlySignal<ObjectBox | null> = computed(() => {
  if (picked.value === NONE) return null;
  const label = state.activeLabel.value;
  const one = boxes.value.get(picked.value);
  if (one?.label === label) return one;
  const own = [...boxes.value.values()].filter((box) => box.label === label);
  return own.find((box) => String(state.frame.value) in box.poses) ?? own[0] ?? null;
});
