/** The desk's camera: turn around the place under the cursor, move, zoom to the cursor, walk. */
import { Euler, MathUtils, Quaternion, Vector3 } from 'three';
import type { Lens } from '../cloud/picture/lens';
import type { View } from '../store/types';

const TURN = 0.0052;
const PITCH_LIMIT = Math.PI / 2;
const NEAREST = 0.02;
/** Half the height of the closest orthographic picture, metres. */
const LEAST_HALF = 0.01;
/** A notch of the wheel reduces the distance of the target to this part. */
const NOTCH = 0.86;
/** Part of an orthographic picture that is crossed in a second. */
const SLIDE = 0.8;
const WALK_KEYS = ['w', 'a', 's', 'd', 'e', 'q', 'shift'];

/** Begin or end of a flight; `half`: of an orthographic picture, 0: perspective. */
interface Station {
  readonly position: Vector3;
  readonly quaternion: Quaternion;
  half: number;
}

function station(): Station {
  return { position: new Vector3(), quaternion: new Quaternion(), half: 0 };
}

export class DeskCamera {
  /** Pivot of turning and target of zooming; room coordinates. */
  readonly pivot = new Vector3();
  /** Metres a second. */
  walkSpeed = 2;
  /** Distance of an orthographic eye, so that all lies before it; metres. */
  depth = 100;
  private readonly held = new Set<string>();
  private readonly euler = new Euler(0, 0, 0, 'YXZ');
  private readonly offset = new Vector3();
  private readonly scratch = new Vector3();
  private readonly from = station();
  private readonly to = station();
  private flightStart = 0;
  private flying = false;
  private lastWalk = 0;

  constructor(readonly camera: Lens) {
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
    if (camera.orthographic) this.backOff();
  }

  /** Move across the picture by pixels, so that the pivot stays under the cursor. */
  pan(dx: number, dy: number, viewHeight: number): void {
    this.land();
    const { camera, scratch } = this;
    const depth = Math.max(0.2, this.depthOf(this.pivot));
    const metres = (2 * camera.halfHeightAt(depth)) / viewHeight;
    scratch.set(-dx * metres, dy * metres, 0).applyQuaternion(camera.quaternion);
    this.move(scratch);
  }

  /** Move the eye and its target. */
  move(by: Vector3): void {
    this.camera.position.add(by);
    this.pivot.add(by);
  }

  private depthOf(point: Vector3): number {
    const forward = this.scratch.set(0, 0, -1).applyQuaternion(this.camera.quaternion);
    return this.offset.copy(point).sub(this.camera.position).dot(forward);
  }

  /** Come closer to `target` (negative: back away) by notches of the wheel. */
  zoom(notches: number, target: Vector3): void {
    this.land();
    const { camera, offset } = this;
    const part = NOTCH ** notches;
    offset.copy(target).sub(camera.position);
    if (camera.orthographic) {
      const half = Math.max(LEAST_HALF, camera.halfHeight * part);
      const forward = this.scratch.set(0, 0, -1).applyQuaternion(camera.quaternion);
      offset.addScaledVector(forward, -offset.dot(forward));
      camera.position.addScaledVector(offset, 1 - half / camera.halfHeight);
      camera.setHalfHeight(half);
      return;
    }
    const distance = offset.length();
    const wanted = Math.max(NEAREST, distance * part);
    camera.position.addScaledVector(offset, (distance - wanted) / Math.max(distance, 1e-6));
  }

  /** A walking key went down or up; true when it is one. */
  key(name: string, down: boolean): boolean {
    if (!WALK_KEYS.includes(name)) return false;
    if (down) this.held.add(name);
    else this.held.delete(name);
    return name !== 'shift';
  }

  releaseKeys(): void {
    this.held.clear();
  }

  /** Fly to a view, or `jump` to it.  `orthographic`: the target keeps its size. */
  lookAt(eye: Vector3, target: Vector3, jump = false, orthographic = false): void {
    const { camera } = this;
    const distance = eye.distanceTo(target);
    this.flyTo(eye, target, orthographic ? camera.halfHeightOf(distance) : 0, jump);
  }

  /** Fly to a place from where one looks now; `half`: metres from there to the upper edge. */
  approach(target: Vector3, half: number): void {
    const { camera } = this;
    const back = new Vector3(0, 0, 1).applyQuaternion(camera.quaternion);
    const eye = back.multiplyScalar(camera.distanceOf(half)).add(target);
    this.flyTo(eye, target, camera.orthographic ? half : 0, false);
  }

  /** Bring a place to the middle of the picture, from as far as now. */
  aimAt(target: Vector3): void {
    this.land();
    const { camera, offset } = this;
    const distance = Math.max(NEAREST, this.depthOf(target));
    offset.set(0, 0, distance).applyQuaternion(camera.quaternion);
    camera.position.copy(target).add(offset);
    this.pivot.copy(target);
    if (camera.orthographic) this.backOff();
  }

  /** Fly to a kept view. */
  restore({ eye, target, half }: View): void {
    this.flyTo(new Vector3(...eye), new Vector3(...target), half, false);
  }

  /** Return the camera's view, or the one at which it is about to arrive. */
  get view(): View {
    const { position, half } = this.flying ? this.to : this.now();
    return { eye: position.toArray(), target: this.pivot.toArray(), half };
  }

  /** Perspective or orthographic from the same place; the pivot keeps its size. */
  toggleOrthographic(): void {
    this.land();
    const { camera, pivot } = this;
    const half = camera.orthographic ? 0 : camera.halfHeightOf(Math.max(0.1, this.depthOf(pivot)));
    if (half === 0) this.approachPivot();
    camera.setHalfHeight(half);
    if (half > 0) this.backOff();
  }

  private flyTo(eye: Vector3, target: Vector3, half: number, jump: boolean): void {
    const { camera, to } = this;
    if (camera.orthographic && half === 0) {
      this.approachPivot();
      camera.setHalfHeight(0);
    }
    Object.assign(this.from, this.now());
    to.position.copy(eye);
    to.half = half;
    const dx = target.x - eye.x;
    const dy = target.y - eye.y;
    const dz = target.z - eye.z;
    const pitch = Math.atan2(dy, Math.hypot(dx, dz));
    const flat = Math.hypot(dx, dz) > 1e-6 * Math.abs(dy);
    // Straight down has no bearing: north stays up.
    this.euler.set(MathUtils.clamp(pitch, -PITCH_LIMIT, PITCH_LIMIT), flat ? Math.atan2(-dx, -dz) : 0, 0); // prettier-ignore
    to.quaternion.setFromEuler(this.euler);
    this.pivot.copy(target);
    this.flying = true;
    this.flightStart = jump ? -Infinity : performance.now();
  }

  private now(): Station {
    const { position, quaternion, halfHeight } = this.camera;
    return { position: position.clone(), quaternion: quaternion.clone(), half: halfHeight };
  }

  /** An orthographic eye goes so far from the pivot that nothing lies behind it. */
  private backOff(): void {
    const back = this.depth - this.depthOf(this.pivot);
    this.scratch.set(0, 0, 1).applyQuaternion(this.camera.quaternion);
    this.camera.position.addScaledVector(this.scratch, back);
  }

  /** To where a picture in perspective shows the pivot as large as it is now. */
  private approachPivot(): void {
    const { camera } = this;
    const near = camera.distanceOf(camera.halfHeight);
    const ahead = this.depthOf(this.pivot) - near;
    this.scratch.set(0, 0, -1).applyQuaternion(camera.quaternion);
    camera.position.addScaledVector(this.scratch, ahead);
  }

  /** Advance; true when the picture changes. */
  update(now: number): boolean {
    const moved = this.fly();
    return this.walk(now) || moved;
  }

  private fly(): boolean {
    if (!this.flying) return false;
    const { camera, from, to } = this;
    const t = Math.min(1, (performance.now() - this.flightStart) / 350);
    const s = t * t * (3 - 2 * t);
    camera.position.lerpVectors(from.position, to.position, s);
    camera.quaternion.slerpQuaternions(from.quaternion, to.quaternion, s);
    if (from.half > 0 && to.half > 0) {
      camera.setHalfHeight(from.half * (to.half / from.half) ** s);
      this.backOff();
    }
    if (t >= 1) this.arrive();
    return true;
  }

  private arrive(): void {
    this.flying = false;
    if (this.to.half === 0) return;
    this.camera.setHalfHeight(this.to.half);
    this.backOff();
  }

  /** End a flight as soon as the user moves the camera. */
  private land(): void {
    if (this.flying && this.to.half > 0 && !this.camera.orthographic) this.arrive();
    this.flying = false;
  }

  private walk(now: number): boolean {
    const seconds = Math.min(0.1, (now - this.lastWalk) / 1000);
    this.lastWalk = now;
    const one = (key: string): number => Number(this.held.has(key));
    const [ahead, right, up] = [one('w') - one('s'), one('d') - one('a'), one('e') - one('q')];
    if (ahead === 0 && right === 0 && up === 0) return false;
    this.land();
    const { offset, camera } = this;
    // Things ahead do not grow in an orthographic picture: one slides over them instead.
    if (camera.orthographic) offset.set(right, ahead + up, 0).applyQuaternion(camera.quaternion);
    else {
      offset.set(right, 0, -ahead).applyQuaternion(camera.quaternion);
      offset.y += up;
    }
    const speed = camera.orthographic ? SLIDE * camera.halfHeight : this.walkSpeed;
    offset.setLength(seconds * speed * (this.held.has('shift') ? 4 : 1));
    this.move(offset);
    return true;
  }
}
