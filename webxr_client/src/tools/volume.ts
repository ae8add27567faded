/** An upright box in the room, to select by or to clip to: where it is, and how handles change it. */
import { signal } from '@preact/signals';
import { Matrix4, Quaternion, Ray, Vector3 } from 'three';
import type { ClipBox } from '../protocol/messages';

/** Room coordinates: y up, metres. */
export interface Volume {
  readonly center: readonly [number, number, number];
  /** Full edges along its own x, y and z. */
  readonly size: readonly [number, number, number];
  /** About y, radians. */
  readonly yaw: number;
  /** Rotation before the yaw, x, y, z, w, for boxes that are not upright. */
  readonly tilt?: readonly [number, number, number, number];
}

/** A face by its axis and side, the middle, or the knob that turns. */
export type Handle = { readonly axis: 0 | 1 | 2; readonly side: 1 | -1 } | 'move' | 'turn';

const UP = new Vector3(0, 1, 0);
/** The shortest edge, metres. */
const SHORTEST = 0.01;
/** Wider than any recording, metres: the wire has no faces that are not there. */
export const ENDLESS = 1e6;
/** Rays flatter than this to the floor move a box across the picture, not along the floor. */
const FLAT = 0.2;
/** The knob that turns stands out by this part of the longer edge. */
const KNOB = 0.65;

/** The box's axes in the room. */
export function turnOf({ yaw, tilt }: Volume): Quaternion {
  const turn = new Quaternion().setFromAxisAngle(UP, yaw);
  return tilt ? turn.multiply(new Quaternion(...tilt)) : turn;
}

/** `T_room_box`, from the cube of edges 2 about the origin. */
export function matrixOf(volume: Volume): Matrix4 {
  const { center, size } = volume;
  const half = new Vector3(...size).multiplyScalar(0.5);
  return new Matrix4().compose(new Vector3(...center), turnOf(volume), half);
}

/** The box's own axis in the room. */
export function axisOf(volume: Volume, axis: 0 | 1 | 2): Vector3 {
  return new Vector3().setComponent(axis, 1).applyQuaternion(turnOf(volume));
}

/** A box in source coordinates, as strokes have it; `T_room_local` and source minus local. */
export function toSource(
  volume: Volume,
  room: Matrix4,
  shift: readonly [number, number, number],
): Required<ClipBox> {
  const { center, size } = volume;
  const local = room.clone().invert();
  const middle = new Vector3(...center).applyMatrix4(local).add(new Vector3(...shift));
  const turn = new Quaternion().setFromRotationMatrix(local);
  const { x, y, z, w } = turn.multiply(turnOf(volume));
  return { center: middle.toArray(), size: [...size], quaternion: [x, y, z, w] };
}

/** Place of a handle, room coordinates. */
export function placeOf(volume: Volume, handle: Handle): Vector3 {
  const center = new Vector3(...volume.center);
  if (handle === 'move') return center;
  if (handle === 'turn') {
    const reach = KNOB * Math.max(volume.size[0], volume.size[2]);
    return center.addScaledVector(axisOf(volume, 0), reach);
  }
  const half = (handle.side * volume.size[handle.axis]) / 2;
  return center.addScaledVector(axisOf(volume, handle.axis), half);
}

/** The box once a handle was dragged from one ray to another (room coordinates). */
export function dragged(volume: Volume, handle: Handle, from: Ray, to: Ray): Volume {
  if (handle === 'move') return moved(volume, from, to);
  if (handle === 'turn') return turned(volume, from, to);
  const { axis, side } = handle;
  const way = axisOf(volume, axis).multiplyScalar(side);
  const at = placeOf(volume, handle);
  const grown = along(at, way, to) - along(at, way, from);
  return Number.isFinite(grown) ? stretched(volume, axis, side, grown) : volume;
}

/** A face moves outward by metres; the one across from it stays. */
function stretched(volume: Volume, axis: 0 | 1 | 2, side: 1 | -1, by: number): Volume {
  const size: [number, number, number] = [...volume.size];
  size[axis] = Math.max(SHORTEST, size[axis] + by);
  const half = (side * (size[axis] - volume.size[axis])) / 2;
  return { ...shifted(volume, axisOf(volume, axis).multiplyScalar(half)), size };
}

export function shifted(volume: Volume, by: Vector3): Volume {
  const center = new Vector3(...volume.center).add(by).toArray();
  return { ...volume, center };
}

/** Metres along a line (from `at`, `way` of unit length) to the place nearest to a ray. */
function along(at: Vector3, way: Vector3, { origin, direction }: Ray): number {
  const between = at.clone().sub(origin);
  const slant = way.dot(direction);
  const apart = 1 - slant * slant;
  // If the line is parallel to the ray, the distance is undefined.
  if (apart < 1e-4) return NaN;
  return (slant * direction.dot(between) - way.dot(between)) / apart;
}

/** Place of a ray in the plane through `at` that its handle moves in; null where it has none. */
function onPlane(ray: Ray, at: Vector3, flat: boolean): Vector3 | null {
  const normal = flat ? ray.direction.clone().setY(0).normalize() : UP;
  const slope = normal.dot(ray.direction);
  const distance = normal.dot(at.clone().sub(ray.origin)) / slope;
  return Number.isFinite(distance) ? ray.at(distance, new Vector3()) : null;
}

function moved(volume: Volume, from: Ray, to: Ray): Volume {
  const flat = Math.abs(from.direction.y) < FLAT;
  const at = new Vector3(...volume.center);
  const [a, b] = [onPlane(from, at, flat), onPlane(to, at, flat)];
  return a && b ? shifted(volume, b.sub(a)) : volume;
}

function turned(volume: Volume, from: Ray, to: Ray): Volume {
  const at = new Vector3(...volume.center);
  const angle = (ray: Ray): number => {
    const place = onPlane(ray, at, false)?.sub(at);
    return place ? Math.atan2(-place.z, place.x) : NaN;
  };
  const by = angle(to) - angle(from);
  return Number.isFinite(by) ? { ...volume, yaw: volume.yaw + by } : volume;
}

/** The box over a rectangle on the floor, from corner to corner, turned as the eye is. */
export function spanned(
  a: Vector3,
  b: Vector3,
  yaw: number,
  bottom: number,
  height: number,
): Volume {
  const turn = new Quaternion().setFromAxisAngle(UP, -yaw);
  const across = b.clone().sub(a).applyQuaternion(turn);
  const middle = a.clone().add(b).multiplyScalar(0.5);
  return {
    center: [middle.x, bottom + height / 2, middle.z],
    size: [
      Math.max(SHORTEST, Math.abs(across.x)),
      Math.max(SHORTEST, height),
      Math.max(SHORTEST, Math.abs(across.z)),
    ],
    yaw,
  };
}

/** The box with its bottom at a height and its top where it was. */
export function standing(volume: Volume, bottom: number): Volume {
  return stretched(volume, 1, -1, volume.center[1] - volume.size[1] / 2 - bottom);
}

/** The box of the box tool, until Enter takes the points in it. */
export const boxDraft = signal<Volume | null>(null);
