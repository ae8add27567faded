/** Points around the chosen box, at full density, for its three views. */
import { signal } from '@preact/signals';
import type { CloudFrame } from '../cloud/points/frame';
import { inBox } from '../cloud/points/pick';
import { DELETED } from '../cloud/points/piece';
import type { Triple } from '../store/boxes';
import { intoBox, type Shape } from './shape';

/** Points of a frame around a box, in the box's own coordinates. */
export interface Near {
  /** The box that the views stand still over; source coordinates. */
  readonly anchor: Shape;
  /** x, y, z one after another, metres. */
  readonly places: Float32Array;
  readonly labels: Uint16Array;
}

/** Null: no box is chosen in this frame. */
export const near = signal<Near | null>(null);

/** Share of `MARGIN` that the views leave around the box. */
export const zoom = signal(1);
export const [NEAREST, FARTHEST] = [0.35, 5];

/** Metres around a box, and the same as a part of its longest edge: the greater counts. */
const [MARGIN, MARGIN_PART] = [0.6, 0.22];
/** Greatest ratio of a view's width to the part that must be visible. */
const WIDE = 2.4;
/** Metres under and over the box that its views also show. */
const OVER = 0.5;

/** Half of the room a view shows along each axis at least, metres. */
export function reachOf({ size }: Shape): Triple {
  const margin = zoom.value * Math.max(MARGIN, MARGIN_PART * Math.max(...size));
  return size.map((edge) => edge / 2 + margin) as [number, number, number];
}

/** Collect the points around a box; `shift`: source minus local. */
export function pointsNear(frame: CloudFrame, anchor: Shape, shift: Triple): Near {
  const [x, y, z] = reachOf(anchor);
  const reach: Triple = [2 * WIDE * x, 2 * WIDE * y, 2 * z + 2 * OVER];
  const centre = anchor.centre.map((at, k) => at - shift[k]!) as [number, number, number];
  const found: number[] = [];
  inBox(frame, centre, reach, anchor.quaternion, (point) => {
    if (frame.labelOf(point) !== DELETED) found.push(point);
  });
  const places = new Float32Array(3 * found.length);
  const labels = new Uint16Array(found.length);
  const local: Shape = { ...anchor, centre };
  found.forEach((point, i) => {
    const { words, origin, scale, first } = frame.pieceOf(point)!;
    const w = 6 * (point - first);
    const at = (k: 0 | 1 | 2): number => origin[k] + words[w + k]! * scale[k];
    places.set(intoBox(local, [at(0), at(1), at(2)]), 3 * i);
    labels[i] = frame.labelOf(point);
  });
  return { anchor, places, labels };
}
