/** Values of label by example: the server's answers, and values that the page derives from them. */
import { MOST_CLASSES, PREDICTED, SURE_STEPS } from '../cloud/picture/palette';
import { FADED, mixed, UNKNOWN } from '../engine/labels/colouring';
import type { Label } from '../protocol/messages';

/** Class and confidence of each point of a frame, in stored order, or of some of its points. */
export interface Prediction {
  /** Stored numbers of the points, ascending; null: all. */
  readonly numbers: Uint32Array | null;
  /** Class from 1; 0 where nothing taught it. */
  readonly kind: Uint8Array;
  /** 0 not at all sure, 255 sure. */
  readonly confidence: Uint8Array;
  /** Numbers of two classes, and the points that are in doubt between them. */
  readonly confused: readonly (readonly [one: number, other: number, points: number])[];
  /** Places in doubt of each class. */
  readonly doubts: readonly number[];
}

/** Read a prediction: the length of its head, the head as JSON, numbers of points, classes, confidences. */
export function predictionOf(bytes: ArrayBuffer): Prediction {
  const length = new DataView(bytes).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length))) as {
    readonly points: number;
    readonly part?: boolean;
  } & Pick<Prediction, 'confused' | 'doubts'>;
  const { points, confused, doubts } = head;
  const numbers = head.part ? new Uint32Array(bytes, 4 + length, points) : null;
  const at = 4 + length + (numbers?.byteLength ?? 0);
  const kind = new Uint8Array(bytes, at, points);
  const confidence = new Uint8Array(bytes, at + points, points);
  return { numbers, kind, confidence, confused, doubts };
}

/** Frames in which doubts are looked for. */
export type Scope = 'frame' | 'recording' | 'workspace';

/** Below this a point is in doubt, of 255. */
export const UNSURE_BELOW = 64;

/** Ids of the palette's texture for the predicted class of each point. */
export function idsOf({ kind, confidence }: Prediction): Uint16Array {
  const ids = new Uint16Array(kind.length);
  for (let i = 0; i < ids.length; i++) {
    const k = kind[i]!;
    if (k === 0 || k > MOST_CLASSES) continue;
    ids[i] = PREDICTED + (k - 1) * SURE_STEPS + Math.floor((confidence[i]! * SURE_STEPS) / 256);
  }
  return ids;
}

/** Points of one class, or of all together. */
export interface Tally {
  readonly points: number;
  readonly unsure: number;
  /** Sum of the confidences, 0..1 each. */
  readonly sure: number;
}

/**
 * Points of each class, from 1, that are predicted with at least the confidence `least`, 0..255;
 * `takes` tells which points count.  The first entry counts all.
 */
export function talliesOf(
  { kind, confidence }: Prediction,
  classes: number,
  least = 0,
  takes: (point: number) => boolean = () => true,
): Tally[] {
  const rows = Array.from({ length: classes + 1 }, () => ({ points: 0, unsure: 0, sure: 0 }));
  for (let i = 0; i < kind.length; i++) {
    const k = kind[i]!;
    const sure = confidence[i]!;
    if (k === 0 || k > classes || sure < least || !takes(i)) continue;
    for (const row of [rows[0]!, rows[k]!]) {
      row.points += 1;
      row.sure += sure / 255;
      if (sure < UNSURE_BELOW) row.unsure += 1;
    }
  }
  return rows;
}

/** Share of grey in the colour of the least sure points. */
const FADE = 0.75;

/** Colours of the ids of `idsOf`; of all classes but `only` none stays. */
export function mapColours(colours: readonly string[], only: number | null): string[] {
  return colours.flatMap((colour, k) =>
    Array.from({ length: SURE_STEPS }, (_, step) => {
      const fade = only !== null && only !== k ? 1 : FADE * (1 - step / (SURE_STEPS - 1));
      return mixed(colour, FADED, fade);
    }),
  );
}

/** The class that a label is of: its category, or its name where it has none. */
export function classOf(label: Label): string {
  return label.category || label.name;
}

/** The label of a palette for a class; undefined: there is none. */
export function labelOf(name: string, palette: readonly Label[]): Label | undefined {
  const alike = palette.filter((label) => classOf(label) === name);
  return alike.find((label) => label.name === name) ?? alike[0];
}

/** A colour for each class. */
export function coloursOf(classes: readonly string[], palette: readonly Label[]): string[] {
  return classes.map((name) => labelOf(name, palette)?.color ?? UNKNOWN);
}
