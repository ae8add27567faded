/** The desk's camera: turn round what is under the cursor, move, zoom to the cursor, walk. */
import { Euler, MathUtils, Quaternion, Vector3, type PerspectiveCamera } from 'three';

const TURN = 0.0052;
const PITCH_LIMIT = Math.PI / 2 - 0.01;
const NEAREST = 0.02;

export class DeskCamera {
  /** What turning goes round and zooming goes to; room coordinates. */
  readonly pivot = new Vector3();
  /** Metres a second. */
  walkSpeed = 2;
  private readonly held = new Set<string>();
  private readonly euler = new Euler(0, 0, 0, 'YXZ');
  private readonly offset = new Vector3();
  private readonly scratch = new Vector3();
  private readonly from = { position: new Vector3(), quaternion: new Quaternion() };
  private readonly to = { position: new Vector3(), quaternion: new Quaternion() };
  private flightStart = 0;
  private flying = false;
  private lastWalk = 0;

  constructor(readonly camera: PerspectiveCamera) {
    this.euler.setFromQuaternion(camera.quaternion);
  }

  /** Turn by pixels of drag. */
  turn(dx: number, dy: number): void {
    this.land();
    const { camera, euler, offset } = this;
    euler.setFromQuaternion(camera.quaternion);
    const pitch = MathUtils.clamp(euler.x - dy * TURN, -PITCH_LIMIT, PITCH_LIMIT);
    const rise = pitch - euler.x;
    const round = -dx * TURN;
    offset.copy(camera.position).sub(this.pivot);
    this.scratch.set(1, 0, 0).applyQuaternion(camera.quaternion);
    offset.applyAxisAngle(this.scratch, rise);
    offset.applyAxisAngle(camera.up, round);
    camera.position.copy(this.pivot).add(offset);
    euler.set(pitch, euler.y + round, 0);
    camera.quaternion.setFromEuler(euler);
  }

  /** Move across the picture by pixels, so that the pivot stays under the cursor. */
  pan(dx: number, dy: number, viewHeight: number): void {
    this.land();
    const { camera, scratch } = this;
    const depth = Math.max(0.2, this.depthOf(this.pivot));
    const metres = (2 * depth * Math.tan(MathUtils.degToRad(camera.fov / 2))) / viewHeight;
    scratch.set(-dx * metres, dy * metres, 0).applyQuaternion(camera.quaternion);
    camera.position.add(scratch);
    this.pivot.add(scratch);
  }

  private depthOf(point: Vector3): number {
    const forward = this.scratch.set(0, 0, -1).applyQuaternion(this.camera.quaternion);
    return this.offset.copy(point).sub(this.camera.position).dot(forward);
  }

  /** Come closer to `target` (negative: back away) by notches of the wheel. */
  zoom(notches: number, target: Vector3): void {
    this.land();
    const { camera, offset } = this;
    offset.copy(target).sub(camera.position);
    const distance = offset.length();
    const wanted = Math.max(NEAREST, distance * 0.86 ** notches);
    camera.position.addScaledVector(offset, (distance - wanted) / Math.max(distance, 1e-6));
  }

  /** A walking key went down or up; true when it is one. */
  key(name: string, down: boolean): boolean {
    if (!['w', 'a', 's', 'd', 'shift'].includes(name)) return false;
    if (down) this.held.add(name);
    else this.held.delete(name);
    return name !== 'shift';
  }

  releaseKeys(): void {
    this.held.clear();
  }

  /** Fly to a view in a moment; at once with `jump`. */
  lookAt(eye: Vector3, target: Vector3, jump = false): void {
    const { camera, from, to } = this;
    from.position.copy(camera.position);
    from.quaternion.copy(camera.quaternion);
    to.position.copy(eye);
    const dx = target.x - eye.x;
    const dy = target.y - eye.y;
    const dz = target.z - eye.z;
    const pitch = Math.atan2(dy, Math.hypot(dx, dz));
    this.euler.set(MathUtils.clamp(pitch, -PITCH_LIMIT, PITCH_LIMIT), Math.atan2(-dx, -dz), 0);
    to.quaternion.setFromEuler(this.euler);
    this.pivot.copy(target);
    this.flying = true;
    this.flightStart = jump ? -Infinity : performance.now();
  }

  /** Advance; true when the picture changes. */
  update(now: number): boolean {
    const moved = this.fly();
    return this.walk(now) || moved;
  }

  private fly(): boolean {
    if (!this.flying) return false;
    const t = Math.min(1, (performance.now() - this.flightStart) / 350);
    const s = t * t * (3 - 2 * t);
    this.camera.position.lerpVectors(this.from.position, this.to.position, s);
    this.camera.quaternion.slerpQuaternions(this.from.quaternion, this.to.quaternion, s);
    if (t >= 1) this.flying = false;
    return true;
  }

  /** A person who takes the camera has it at once. */
  private land(): void {
    this.flying = false;
  }

  private walk(now: number): boolean {
    const seconds = Math.min(0.1, (now - this.lastWalk) / 1000);
    this.lastWalk = now;
    const ahead = Number(this.held.has('w')) - Number(this.held.has('s'));
    const right = Number(this.held.has('d')) - Number(this.held.has('a'));
    if (ahead === 0 && right === 0) return false;
    this.land();
    const { scratch, offset, camera } = this;
    offset.set(0, 0, -1).applyQuaternion(camera.quaternion).multiplyScalar(ahead);
    scratch.set(1, 0, 0).applyQuaternion(camera.quaternion).multiplyScalar(right);
    offset.add(scratch).normalize();
    offset.multiplyScalar(seconds * this.walkSpeed * (this.held.has('shift') ? 4 : 1));
    camera.position.add(offset);
    this.pivot.add(offset);
    return true;
  }
}
