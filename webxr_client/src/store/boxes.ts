/** Boxes of the open recording: what the server told, under the changes that it has not answered. */
import { computed, signal, type ReadonlySignal } from '@preact/signals';
import { state } from './state';

export type Triple = readonly [number, number, number];
/** x, y, z, w. */
export type Quad = readonly [number, number, number, number];
export type AttributeValue = string | number | boolean;
export type Attributes = Readonly<Record<string, AttributeValue>>;

/** Place of a box in a frame, source coordinates, from the box's axes: x forward, y left, z up. */
export interface BoxPose {
  readonly centre: Triple;
  readonly quaternion: Quad;
  readonly provenance: 'fitted' | 'drawn' | 'imported';
  /** 0..1. */
  readonly confidence: number;
  readonly attributes: Attributes;
}

export interface ObjectBox {
  readonly id: number;
  readonly label: number;
  /** Length, width, height, metres: one size in all frames. */
  readonly size: Triple;
  /** By frame number. */
  readonly poses: Readonly<Record<string, BoxPose>>;
  readonly attributes: Attributes;
  readonly provenance: BoxPose['provenance'];
}

/** A change as REST takes it: members are merged, null removes. */
export interface BoxPatch {
  readonly label?: number;
  readonly size?: Triple;
  readonly poses?: Readonly<Record<string, BoxPose | null>>;
  readonly attributes?: Readonly<Record<string, AttributeValue | null>>;
}

export interface BoxesTold {
  readonly revision: number;
  readonly boxes: readonly ObjectBox[];
  readonly removed: readonly number[];
  /** These are all that there are. */
  readonly whole: boolean;
}

interface Waiting {
  readonly id: number;
  readonly patch: BoxPatch | null;
}

/** What the server told last, and the revision at which it told each box. */
const told = signal<ReadonlyMap<number, ObjectBox>>(new Map());
const revisions = new Map<number, number>();
/** Changes on their way, oldest first; a null patch removes the box. */
const waiting = signal<readonly Waiting[]>([]);

/** Boxes by id, with the changes that are on their way. */
export const boxes: ReadonlySignal<ReadonlyMap<number, ObjectBox>> = computed(() => {
  if (waiting.value.length === 0) return told.value;
  const now = new Map(told.value);
  for (const { id, patch } of waiting.value) {
    const box = now.get(id);
    if (!box) continue;
    if (patch) now.set(id, patched(box, patch));
    else now.delete(id);
  }
  return now;
});

/** A record with some members replaced, and those that are null removed. */
export function merged<T>(
  before: Readonly<Record<string, T>>,
  changes: Readonly<Record<string, T | null>>,
): Record<string, T> {
  const all: Record<string, T | null> = { ...before, ...changes };
  return Object.fromEntries(
    Object.entries(all).filter((entry): entry is [string, T] => entry[1] !== null),
  );
}

export function patched(box: ObjectBox, { poses, attributes, ...rest }: BoxPatch): ObjectBox {
  return {
    ...box,
    ...rest,
    poses: poses ? merged(box.poses, poses) : box.poses,
    attributes: attributes ? merged(box.attributes, attributes) : box.attributes,
  };
}

/** Take in what the server tells; what is older than what is known of a box is left. */
export function takeBoxes({ revision, boxes: some, removed, whole }: BoxesTold): void {
  const now = new Map(whole ? [] : told.peek());
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
  told.value = now;
}

/** No recording is open. */
export function forgetBoxes(): void {
  revisions.clear();
  told.value = new Map();
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
