/** Place of a label's points in a frame. */
import { Vector3 } from 'three';
import type { CloudFrame } from './frame';

export interface LabelPlace {
  /** Mean of the points, local coordinates. */
  readonly middle: Vector3;
  /** Of a ball round the middle that holds all but strays, metres. */
  readonly radius: number;
  readonly points: number;
}

/** Points of a solid lie up to about so many times their mean square distance from its middle. */
const REACH = 1.7;
let labels = new Uint16Array(0);

/** Null where the frame has no point of the label, as shown. */
export function placeOfLabel(frame: CloudFrame, label: number): LabelPlace | null {
  // Chunks of large frames arrive in any order: numbers may exceed the count of loaded points.
  if (labels.length < frame.total) labels = new Uint16Array(frame.total);
  frame.gatherLabels(labels, frame.total);
  const sums = [0, 0, 0];
  let squares = 0;
  let points = 0;
  for (const { first, count, words, origin, scale } of frame.pieces) {
    for (let i = 0; i < count; i++) {
      if (labels[first + i] !== label) continue;
      points += 1;
      for (let k = 0; k < 3; k++) {
        const value = origin[k]! + words[6 * i + k]! * scale[k]!;
        sums[k]! += value;
        squares += value * value;
      }
    }
  }
  if (points === 0) return null;
  const middle = new Vector3(...(sums as [number, number, number])).divideScalar(points);
  const spread = Math.max(0, squares / points - middle.lengthSq());
  return { middle, radius: REACH * Math.sqrt(spread), points };
}
