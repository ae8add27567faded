/** Geometry of a box in one frame, and its changes by handles, keys and copies. */
import { Matrix4, Quaternion, Vector3 } from 'three';
import type { BoxPatch, BoxPose, ObjectBox, Quad, Triple } from '../store/boxes';

/** A box in one frame, source coordinates: axes x forward, y left, z up. */
export interface Shape {
  readonly size: Triple;
  readonly centre: Triple;
  readonly quaternion: Quad;
}

export type Axis = 0 | 1 | 2;
export type Side = -1 | 0 | 1;

/** The shortest edge, metres. */
export const SHORTEST = 0.05;

export function shapeIn({ size, poses }: ObjectBox, frame: number): Shape | null {
  const pose = poses[frame];
  return pose ? { size, centre: pose.centre, quaternion: pose.quaternion } : null;
}

/** A place or way along the box's axes, turned into the frame's. */
export function fromBox({ quaternion }: Shape, way: Triple): Vector3 {
  return new Vector3(...way).applyQuaternion(new Quaternion(...quaternion));
}

/** A place of the frame in the box's coordinates. */
export function intoBox({ centre, quaternion }: Shape, place: Triple): Triple {
  const [x, y, z] = centre;
  return new Vector3(place[0] - x, place[1] - y, place[2] - z)
    .applyQuaternion(new Quaternion(...quaternion).conjugate())
    .toArray();
}

/** A corner, an edge's or a face's middle by its sides, in the frame. */
export function placeOn(shape: Shape, sides: readonly [Side, Side, Side]): Triple {
  const { size, centre } = shape;
  const half = sides.map((side, axis) => (side * size[axis]!) / 2) as [number, number, number];
  return plus(centre, fromBox(shape, half));
}

function plus([x, y, z]: Triple, by: Vector3): Triple {
  return [x + by.x, y + by.y, z + by.z];
}

/** The box moved along its own axes, metres. */
export function moved(shape: Shape, by: Triple): Shape {
  return { ...shape, centre: plus(shape.centre, fromBox(shape, by)) };
}

/** The given sides move outward by `by` along their axes; the opposite sides stay. */
export function stretched(shape: Shape, sides: readonly [Side, Side, Side], by: Triple): Shape {
  const size: [number, number, number] = [...shape.size];
  const shift: [number, number, number] = [0, 0, 0];
  sides.forEach((side, axis) => {
    if (side === 0) return;
    size[axis] = Math.max(SHORTEST, size[axis]! + side * by[axis]!);
    shift[axis] = (side * (size[axis] - shape.size[axis]!)) / 2;
  });
  return { ...moved(shape, shift), size };
}

/** The box turned about one of its own axes, radians. */
export function turned(shape: Shape, axis: Axis, angle: number): Shape {
  const way = new Vector3().setComponent(axis, 1);
  const turn = new Quaternion().setFromAxisAngle(way, angle);
  return { ...shape, quaternion: quad(new Quaternion(...shape.quaternion).multiply(turn)) };
}

function quad(turn: Quaternion): Quad {
  const { x, y, z, w } = turn.normalize();
  return [x, y, z, w];
}

/** Return a pose moved rigidly to another frame; `T_other_frame` in source coordinates. */
export function carried<T extends Pick<Shape, 'centre' | 'quaternion'>>(
  pose: T,
  T_other_frame: Matrix4,
): T {
  const turn = new Quaternion().setFromRotationMatrix(T_other_frame);
  return {
    ...pose,
    centre: new Vector3(...pose.centre).applyMatrix4(T_other_frame).toArray(),
    quaternion: quad(turn.multiply(new Quaternion(...pose.quaternion))),
  };
}

type Placed = Pick<Shape, 'centre' | 'quaternion'>;

/** The pose on the way from one to another, `share` 0..1: straight, turning the shorter way. */
export function between(a: Placed, b: Placed, share: number): Placed {
  const centre = new Vector3(...a.centre).lerp(new Vector3(...b.centre), share).toArray();
  const turn = new Quaternion(...a.quaternion).slerp(new Quaternion(...b.quaternion), share);
  return { centre, quaternion: quad(turn) };
}

/** The frames with drawn poses around `frame`, before or at it and after it; null without both. */
export function drawnAround({ poses }: ObjectBox, frame: number): readonly [number, number] | null {
  const drawn = Object.keys(poses)
    .filter((key) => poses[key]!.provenance === 'drawn')
    .map(Number)
    .sort((a, b) => a - b);
  const before = drawn.filter((index) => index <= frame).at(-1);
  const after = drawn.find((index) => index > (before ?? frame));
  if (before !== undefined && after !== undefined) return [before, after];
  const earlier = drawn.at(-2);
  return before !== undefined && before === frame && earlier !== undefined
    ? [earlier, before]
    : null;
}

/** A drawn pose: a person's, and sure. */
export function drawnPose({ centre, quaternion }: Placed, before?: BoxPose): BoxPose {
  const attributes = before?.attributes ?? {};
  return { centre, quaternion, provenance: 'drawn', confidence: 1, attributes };
}

/**
 * The change of a box by a shape that was drawn in `frame`.  A new size counts in all frames: in
 * each of them the same sides move, so that the others stay where they are.
 */
export function patchOf(box: ObjectBox, frame: number, before: Shape, after: Shape): BoxPatch {
  const poses: Record<string, BoxPose> = { [frame]: drawnPose(after, box.poses[frame]) };
  const same = after.size.every((edge, axis) => Math.abs(edge - before.size[axis]!) < 1e-9);
  if (same) return { poses };
  const shift = intoBox(before, after.centre);
  for (const [key, pose] of Object.entries(box.poses)) {
    if (key === String(frame)) continue;
    const { centre } = moved({ ...pose, size: after.size }, shift);
    poses[key] = { ...pose, centre };
  }
  return { size: after.size, poses };
}

// ── views ──────────────────────────────────────────────────────────────────────────────────────

/** A view along one of the box's axes: the axes to the right and up on screen, and the third one. */
export interface BoxView {
  readonly name: 'Top' | 'Side' | 'Front';
  readonly right: Axis;
  readonly up: Axis;
  readonly near: Axis;
  /** The third axis points to the viewer (1) or away (−1). */
  readonly nearer: 1 | -1;
}

export const BOX_VIEWS: readonly BoxView[] = [
  { name: 'Top', right: 0, up: 1, near: 2, nearer: 1 },
  { name: 'Side', right: 0, up: 2, near: 1, nearer: -1 },
  { name: 'Front', right: 1, up: 2, near: 0, nearer: 1 },
];

/** Handles that a view is dragged by: sides and corners, the inside, the knob. */
export type ViewHandle = { readonly right: Side; readonly up: Side } | 'move' | 'turn';

type Flat = readonly [right: number, up: number];

/** The shape once a handle was dragged, metres along the view's axes from the shape's middle. */
export function draggedIn(
  view: BoxView,
  handle: ViewHandle,
  shape: Shape,
  from: Flat,
  to: Flat,
): Shape {
  const by: [number, number, number] = [0, 0, 0];
  by[view.right] = to[0] - from[0];
  by[view.up] = to[1] - from[1];
  if (handle === 'move') return moved(shape, by);
  if (handle === 'turn') {
    const angle = Math.atan2(to[1], to[0]) - Math.atan2(from[1], from[0]);
    return turned(shape, view.near, view.nearer * angle);
  }
  const sides: [Side, Side, Side] = [0, 0, 0];
  sides[view.right] = handle.right;
  sides[view.up] = handle.up;
  return stretched(shape, sides, by);
}
