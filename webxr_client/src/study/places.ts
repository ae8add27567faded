/** Poses in the coordinates of a recording, and back in the room. */
import { Matrix4, Quaternion, Vector3 } from 'three';
import type { Pose, Vec } from '../store/types';

const [at, turn, scale] = [new Vector3(), new Quaternion(), new Vector3()];

/** Return T_source_scene of a recording that `stand` places in the scene. */
export function sourceFrom(stand: Matrix4, [x, y, z]: Vec): Matrix4 {
  return new Matrix4().makeTranslation(x, y, z).multiply(stand.clone().invert());
}

/** Return a pose after a transformation, which may scale. */
export function movedPose(by: Matrix4, [x, y, z, ...turned]: Pose): Pose {
  by.decompose(at, turn, scale);
  turn.multiply(new Quaternion(...turned));
  at.set(x, y, z).applyMatrix4(by);
  return [...at.toArray(), ...turn.toArray()];
}
