/** Points around a box in one of its views: a picture, coloured by membership in the box. */
import type { Rgb } from '../common/colors';
import type { Near } from './near';
import { fromBox, intoBox, type BoxView, type Shape } from './shape';

/** Scale of a view's picture. */
export interface Scale {
  /** Pixels. */
  readonly width: number;
  readonly height: number;
  readonly perMetre: number;
}

/** Return the scale that shows `reach` (half of the visible extent along each axis, metres). */
export function scaleOf(
  view: BoxView,
  reach: readonly number[],
  width: number,
  height: number,
): Scale {
  const perMetre = Math.min(width / (2 * reach[view.right]!), height / (2 * reach[view.up]!));
  return { width, height, perMetre };
}

export interface Inks {
  /** Points in the box. */
  readonly label: Rgb;
  /** Points outside the box, and points in the box with another label. */
  readonly other: Rgb;
  readonly foreign: Rgb;
}

/** Opacity, of 255: in the box, of its label but outside, the rest at the box's depth, and beyond. */
const [INSIDE, STRAY, BESIDE, BEYOND] = [255, 200, 150, 60];
/** Metres before and behind the box that count as its depth. */
const DEPTH = 0.3;

/** Draw `near` as seen in `view`; points in `shape` stand out. `dot`: pixels across a point. */
export function drawNear(
  pixels: ImageData,
  { anchor, places, labels }: Near,
  shape: Shape,
  label: number,
  view: BoxView,
  { width, height, perMetre }: Scale,
  inks: Inks,
  dot: number,
): number {
  pixels.data.fill(0);
  const inside = insideOf(anchor, shape);
  const reach = shape.size[view.near] / 2 + DEPTH;
  let count = 0;
  // Points that stand out are drawn last.
  for (const pass of [0, 1]) {
    for (let i = 0, w = 0; i < labels.length; i++, w += 3) {
      const within = inside(places[w]!, places[w + 1]!, places[w + 2]!);
      const own = labels[i] === label;
      if ((within || own ? 1 : 0) !== pass) continue;
      if (within) count += 1;
      const u = Math.round(width / 2 + places[w + view.right]! * perMetre);
      const v = Math.round(height / 2 - places[w + view.up]! * perMetre);
      const level = Math.abs(places[w + view.near]!) <= reach;
      const ink = own ? inks.label : within ? inks.foreign : inks.other;
      const alpha = within ? INSIDE : besideAlpha(own, level);
      put(pixels, u, v, within ? dot : Math.max(1, dot - 1), ink, alpha);
    }
  }
  return count;
}

function besideAlpha(own: boolean, level: boolean): number {
  if (own) return STRAY;
  return level ? BESIDE : BEYOND;
}

/** Whether a place (coordinates of `anchor`) is in `shape`. */
function insideOf(anchor: Shape, shape: Shape): (x: number, y: number, z: number) => boolean {
  const { centre } = anchor;
  const middle = intoBox(anchor, shape.centre);
  const axes = [0, 1, 2].map((axis) => {
    const unit = [0, 1, 2].map((k) => (k === axis ? 1 : 0)) as [number, number, number];
    const way = fromBox(shape, unit);
    return intoBox(anchor, [centre[0] + way.x, centre[1] + way.y, centre[2] + way.z]);
  });
  const halves = shape.size.map((edge) => edge / 2);
  return (x, y, z) => {
    const [dx, dy, dz] = [x - middle[0], y - middle[1], z - middle[2]];
    for (let axis = 0; axis < 3; axis++) {
      const [ax, ay, az] = axes[axis]!;
      if (Math.abs(dx * ax + dy * ay + dz * az) > halves[axis]!) return false;
    }
    return true;
  };
}

function put(
  { data, width, height }: ImageData,
  u: number,
  v: number,
  dot: number,
  ink: Rgb,
  alpha: number,
): void {
  for (let y = v; y < v + dot; y++) {
    for (let x = u; x < u + dot; x++) {
      if (x < 0 || y < 0 || x >= width || y >= height) continue;
      const at = 4 * (y * width + x);
      data[at] = ink[0];
      data[at + 1] = ink[1];
      data[at + 2] = ink[2];
      data[at + 3] = Math.max(data[at + 3]!, alpha);
    }
  }
}
