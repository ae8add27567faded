/** The chosen box in the room, for the gizmo of the main view. */
import { Matrix4, Quaternion, Vector3 } from 'three';
import { chosenBox } from '../store/boxes';
import { activeLabel, canEdit, state } from '../store/state';
import { toSource, type Volume } from '../tools/volume';
import { commitDraft, dragTo, shownIn } from './changes';
import type { Shape } from './shape';

/**
 * From a volume's axes (x, y up, z) to a box's axes (x forward, y left, z up): a quarter turn
 * about x.
 */
const AXES = new Quaternion().setFromAxisAngle(new Vector3(1, 0, 0), Math.PI / 2);
/** Tilts below this are none, radians. */
const UPRIGHT = 1e-4;

export type Shift = readonly [number, number, number];

/** A box of a frame as a volume of the room; `room`: `T_room_local`, `shift`: source minus local. */
export function volumeOf({ size, centre, quaternion }: Shape, room: Matrix4, shift: Shift): Volume {
  const center = new Vector3(...centre).sub(new Vector3(...shift)).applyMatrix4(room);
  const turn = new Quaternion().setFromRotationMatrix(room);
  turn.multiply(new Quaternion(...quaternion)).multiply(AXES);
  const forward = new Vector3(1, 0, 0).applyQuaternion(turn);
  const yaw = Math.atan2(-forward.z, forward.x);
  const upright = new Quaternion().setFromAxisAngle(new Vector3(0, 1, 0), yaw);
  const { x, y, z, w } = upright.clone().conjugate().multiply(turn);
  const [length, width, height] = size;
  return {
    center: center.toArray(),
    size: [length, height, width],
    yaw,
    ...(turn.angleTo(upright) > UPRIGHT && { tilt: [x, y, z, w] as const }),
  };
}

/** The box that a volume of the room is; its own x is forward. */
export function shapeOf(volume: Volume, room: Matrix4, shift: Shift): Shape {
  const { center, size, quaternion } = toSource(volume, room, shift);
  const turn = new Quaternion(...quaternion).multiply(AXES.clone().conjugate());
  const [length, height, width] = size;
  return {
    size: [length, width, height],
    centre: center,
    quaternion: [turn.x, turn.y, turn.z, turn.w],
  };
}

/** The volume's turn in the room with its longer level side forward. */
export function lengthwise(volume: Volume): Volume {
  const [x, y, z] = volume.size;
  if (x >= z || volume.tilt) return volume;
  return { ...volume, size: [z, y, x], yaw: volume.yaw + Math.PI / 2 };
}

export interface Gizmo {
  readonly volume: Volume;
  readonly color: string;
  readonly write: (volume: Volume) => void;
  readonly done: () => void;
}

/** The chosen box in the frame on screen, while the tool for boxes is out; else null. */
export function gizmo(room: Matrix4): Gizmo | null {
  const box = chosenBox.peek();
  const info = state.sequence.peek();
  const { frame } = state.shown.peek();
  if (!box || !info || state.tool.peek() !== 'boxes' || !canEdit.peek()) return null;
  const shape = shownIn(box, frame);
  if (!shape) return null;
  return {
    volume: volumeOf(shape, room, info.shift),
    color: activeLabel.peek()?.color ?? '#ffffff',
    write: (volume) => dragTo(box, frame, shapeOf(volume, room, info.shift)),
    done: commitDraft,
  };
}

/** A shape in local coordinates; `shift`: source minus local. */
export function lessShift(shape: Shape, [x, y, z]: Shift): Shape {
  const { centre } = shape;
  return { ...shape, centre: [centre[0] - x, centre[1] - y, centre[2] - z] };
}

/** Metres along a ray (origin, unit direction; the frame's coordinates) to a box; null: not met. */
export function distanceTo(shape: Shape, origin: Vector3, direction: Vector3): number | null {
  const back = new Quaternion(...shape.quaternion).conjugate();
  const from = origin
    .clone()
    .sub(new Vector3(...shape.centre))
    .applyQuaternion(back);
  const way = direction.clone().applyQuaternion(back);
  let [enter, leave] = [0, Infinity];
  for (let axis = 0; axis < 3; axis++) {
    const [at, go, half] = [from.getComponent(axis), way.getComponent(axis), shape.size[axis]! / 2];
    const ends = [(-half - at) / go, (half - at) / go];
    enter = Math.max(enter, Math.min(...ends));
    leave = Math.min(leave, Math.max(...ends));
  }
  return enter <= leave ? enter : null;
}
