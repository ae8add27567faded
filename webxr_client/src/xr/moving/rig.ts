/** Pose of the headset's space in the scene: walking, teleporting and turning move it. */
import { Group, Matrix4, Quaternion, Vector3 } from 'three';
import type { Poses } from '../input/poses';
import { Sight } from './sight';
import { turnBy } from '../drawing/vectors';

const UP = new Vector3(0, 1, 0);

export class Rig {
  readonly group = new Group();
  /** Place of the eyes, in the scene and in the headset's own space. */
  readonly head = new Vector3(0, 1.6, 0);
  readonly headInRig = new Vector3(0, 1.6, 0);
  /** Rotation of the head, in the scene. */
  readonly turned = new Quaternion();
  /** Direction of the eyes in the headset's own space, of unit length. */
  readonly gaze = new Vector3(0, 0, -1);
  /** Level direction of the eyes, in the scene. */
  readonly ahead = new Vector3(0, 0, -1);
  /** Count of moves and turns other than by walking: a stroke would be swept along with them. */
  jumps = 0;
  /** From the headset's own space to the head's. */
  readonly inHead = new Matrix4();
  readonly sight = new Sight();
  private readonly pose = new Matrix4();
  private readonly scratch = new Vector3();

  /** Take in the head's pose; false when it is not known in this frame. */
  update(poses: Poses): boolean {
    this.group.updateMatrixWorld(true);
    if (!poses.head(this.pose)) return false;
    this.headInRig.setFromMatrixPosition(this.pose);
    this.head.copy(this.headInRig).applyMatrix4(this.group.matrixWorld);
    this.inHead.copy(this.pose).invert();
    this.turned.setFromRotationMatrix(this.pose).premultiply(this.group.quaternion);
    const { elements } = this.pose;
    // The third column of the rotation, reversed and laid level.
    const { ahead, gaze } = this;
    gaze.x = -elements[8];
    gaze.y = -elements[9];
    gaze.z = -elements[10];
    ahead.x = -elements[8];
    ahead.y = 0;
    ahead.z = -elements[10];
    if (ahead.x * ahead.x + ahead.z * ahead.z < 1e-6) ahead.set(0, 0, -1);
    turnBy(this.group.matrixWorld, ahead, ahead);
    return true;
  }

  /** Stand with the head above `place`, looking along `way`. */
  standAt(place: Vector3, way: Vector3): void {
    const wanted = Math.atan2(way.x, way.z);
    const now = Math.atan2(this.ahead.x, this.ahead.z);
    this.turn(wanted - now);
    this.moveTo(place);
  }

  /** Bring the head above a place on the floor. */
  moveTo(place: Vector3): void {
    const { position } = this.group;
    position.x += place.x - this.head.x;
    position.z += place.z - this.head.z;
    this.jumps += 1;
    this.refresh();
  }

  /** Turn on the spot, radians, positive to the left. */
  turn(angle: number): void {
    const { group, scratch } = this;
    scratch.copy(this.head).sub(group.position).applyAxisAngle(UP, angle);
    group.position.copy(this.head).sub(scratch);
    group.rotateY(angle);
    this.ahead.applyAxisAngle(UP, angle);
    this.jumps += 1;
    this.refresh();
  }

  /** Let the headset's own floor lie at a height of the scene. */
  liftTo(height: number): void {
    this.group.position.y = height;
    this.refresh();
  }

  /** Glide by a way of the scene. */
  move(by: Vector3): void {
    this.group.position.add(by);
    this.jumps += 1;
    this.refresh();
  }

  private refresh(): void {
    this.group.updateMatrixWorld(true);
    this.head.copy(this.headInRig).applyMatrix4(this.group.matrixWorld);
  }
}
