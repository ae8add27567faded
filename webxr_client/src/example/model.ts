/** Values of label by example: the server's answers by its names, and what the page makes of them. */
import { DOUBT, DOUBT_STEPS, MOST_CLASSES, PREDICTED } from '../cloud/picture/palette';
import { UNKNOWN } from '../engine/colouring';
import type { Label } from '../protocol/messages';

export interface Classifier {
  readonly id: string;
  readonly name: string;
  readonly classes: readonly string[];
  /** Recording → examples of it. */
  readonly taught_by: Readonly<Record<string, number>>;
  /** Class → examples of it. */
  readonly examples: Readonly<Record<string, number>>;
  /** Share of held-out examples that it gets right; null: too few to tell. */
  readonly score: number | null;
}

/** A place whose answer would teach most. */
export interface Question {
  readonly sequence: string;
  readonly frame: number;
  /** Source coordinates, metres. */
  readonly centre: readonly [number, number, number];
  /** Of a stroke that answers, metres. */
  readonly radius: number;
  readonly points: number;
  /** The two classes that it may be, the likelier first. */
  readonly classes: readonly string[];
}

/** Class and confidence of each point of a frame, in stored order, or of some of its points. */
export interface Prediction {
  /** Stored numbers of the points, ascending; null: all. */
  readonly numbers: Uint32Array | null;
  /** Class from 1; 0 where nothing taught it. */
  readonly kind: Uint8Array;
  /** 0 not at all sure, 255 sure. */
  readonly confidence: Uint8Array;
}

/** Read a prediction: the length of its head, the head as JSON, numbers of points, classes, confidences. */
export function predictionOf(bytes: ArrayBuffer): Prediction {
  const length = new DataView(bytes).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length))) as {
    readonly points: number;
    readonly part?: boolean;
  };
  const { points } = head;
  const numbers = head.part ? new Uint32Array(bytes, 4 + length, points) : null;
  const at = 4 + length + (numbers?.byteLength ?? 0);
  const kind = new Uint8Array(bytes, at, points);
  return { numbers, kind, confidence: new Uint8Array(bytes, at + points, points) };
}

export type Shows = 'classes' | 'doubt';

/** Frames in which doubts are looked for. */
export type Scope = 'frame' | 'recording' | 'workspace';

/** Below this a point is in doubt, of 255. */
export const UNSURE_BELOW = 64;

/** Ids of the palette's texture for what is predicted of each point. */
export function idsOf({ kind, confidence }: Prediction, shows: Shows): Uint16Array {
  const ids = new Uint16Array(kind.length);
  for (let i = 0; i < ids.length; i++) {
    const k = kind[i]!;
    if (k === 0 || k > MOST_CLASSES) continue;
    ids[i] =
      shows === 'classes'
        ? PREDICTED + k - 1
        : DOUBT + Math.floor((confidence[i]! * DOUBT_STEPS) / 256);
  }
  return ids;
}

/** Points that are predicted, and those of them in doubt. */
export function countOf({ kind, confidence }: Prediction): { points: number; unsure: number } {
  let points = 0;
  let unsure = 0;
  for (let i = 0; i < kind.length; i++) {
    if (kind[i] === 0) continue;
    points += 1;
    if (confidence[i]! < UNSURE_BELOW) unsure += 1;
  }
  return { points, unsure };
}

/** The class that a label is of: its category, or its name where it has none. */
export function classOf(label: Label): string {
  return label.category || label.name;
}

/** The label that a class is predicted as, of those of a palette; undefined: there is none. */
export function labelOf(name: string, palette: readonly Label[]): Label | undefined {
  const alike = palette.filter((label) => classOf(label) === name);
  return alike.find((label) => label.name === name) ?? alike[0];
}

/** A colour for each class. */
export function coloursOf(classes: readonly string[], palette: readonly Label[]): string[] {
  return classes.map((name) => labelOf(name, palette)?.color ?? UNKNOWN);
}
