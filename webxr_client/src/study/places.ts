/** Poses in the coordinates of a recording, and back in the room. */
import { Matrix4, Quaternion, Vector3 } from 'three';
import type { LogRecord } from '../protocol/values';
import type { Pose, Vec } from '../store/types';

/** Digits of the log: tenths of a millimetre, and thousandths of a degree. */
const DIGITS = 5;

type LoggedPose = NonNullable<LogRecord['head']>;

const [place, turn, scale] = [new Vector3(), new Quaternion(), new Vector3()];

/** Move a pose by a transformation, which may scale, to a place before or after a shift. */
function moved(by: Matrix4, from: Vector3, turned: Quaternion): void {
  by.decompose(place, turn, scale);
  turn.multiply(turned);
  place.copy(from).applyMatrix4(by);
}

/**
 * Poses of the scene in source coordinates: `T_source_scene` is the shift of the recording after
 * the inverse of its stand in the scene.
 */
export class SourcePoses {
  private readonly fromScene = new Matrix4();
  private shift: Vec = [0, 0, 0];

  /** Take in where the recording stands now. */
  update(stand: Matrix4, shift: Vec): void {
    this.fromScene.copy(stand).invert();
    this.shift = shift;
  }

  of(at: Vector3, turned: Quaternion): LoggedPose {
    moved(this.fromScene, at, turned);
    const [x, y, z] = this.shift;
    const values = [place.x + x, place.y + y, place.z + z, turn.x, turn.y, turn.z, turn.w];
    return values.map((value) => Number(value.toFixed(DIGITS))) as unknown as LoggedPose;
  }
}

/** Return a logged pose in the room, where `room` stands the recording on the floor. */
export function inRoom(pose: LoggedPose, room: Matrix4, [x, y, z]: Vec): Pose {
  const [px, py, pz, ...turned] = pose;
  const at = new Vector3(px! - x, py! - y, pz! - z);
  moved(room, at, new Quaternion(...turned));
  return [place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w];
}
