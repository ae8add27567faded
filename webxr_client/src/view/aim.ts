/** Aim of the mouse: rays into the recording, and their hits. */
import type { PointerSample } from '../store/types';
import { Matrix4, Ray, Vector3 } from 'three';
import type { CloudFrame } from '../cloud/points/frame';
import { layers } from '../cloud/points/accumulation';
import { clipMatrix } from '../tools/clip';
import { firstHitAmong, type LayerHit } from '../cloud/points/layer';
import type { Hit } from '../cloud/points/pick';
import { DELETED } from '../cloud/points/piece';
import type { Viewer } from '../cloud/picture/viewer';
import type { SequenceInfo } from '../protocol/messages';
import { state } from '../store/state';
import { isDeleted, seenIn, type Seen } from '../tools/seen';

export class Aim {
  /** Pixels of the canvas. */
  x = 0;
  y = 0;
  inside = false;
  /** Since the brush was drawn last. */
  moved = false;
  private readonly canvas: HTMLCanvasElement;
  private readonly toLocal = new Matrix4();
  private readonly scratch = new Vector3();
  private readonly seen: Seen;

  constructor(
    private readonly viewer: Viewer,
    /** The frame on screen. */
    readonly frame: () => CloudFrame | null,
  ) {
    this.canvas = viewer.canvas;
    this.seen = seenIn(viewer.palette);
  }

  place(event: MouseEvent): void {
    this.x = event.offsetX;
    this.y = event.offsetY;
    this.inside = true;
    this.moved = true;
  }

  /** Aim at the middle of the canvas, as if the cursor was there. */
  placeInMiddle(): void {
    this.x = this.canvas.clientWidth / 2;
    this.y = this.canvas.clientHeight / 2;
    this.inside = this.moved = true;
  }

  /** The ray through a place on the canvas, in local coordinates. */
  ray(x = this.x, y = this.y): PointerSample {
    const { camera, room } = this.viewer;
    camera.updateMatrixWorld();
    const [u, v] = [(x / this.canvas.clientWidth) * 2 - 1, 1 - (y / this.canvas.clientHeight) * 2];
    const far = this.scratch.set(u, v, 0.5).unproject(camera);
    this.toLocal.copy(room.matrixWorld).invert();
    const eye = new Vector3().copy(camera.position);
    // Rays of an orthographic picture are parallel, with different origins.
    if (camera.orthographic) eye.set(u, v, -1).unproject(camera);
    eye.applyMatrix4(this.toLocal);
    const direction = far.applyMatrix4(this.toLocal).sub(eye).normalize();
    return {
      origin: [eye.x, eye.y, eye.z],
      direction: [direction.x, direction.y, direction.z],
    };
  }

  /** The same in room coordinates. */
  roomRay(): Ray {
    const { origin, direction } = this.ray();
    const ray = new Ray(new Vector3(...origin), new Vector3(...direction));
    return ray.applyMatrix4(this.viewer.room.matrixWorld);
  }

  /** Return the hit under the cursor, within `radius` of its ray. */
  hit(radius: number): LayerHit | null {
    const frame = this.frame();
    if (!frame || !this.inside) return null;
    const { origin, direction } = this.ray();
    const meet = (seen: Seen): LayerHit | null =>
      firstHitAmong(frame, layers.peek(), origin, direction, radius, seen, clipMatrix.peek());
    // Restoring reaches deleted points through all that lies before them.
    return (state.tool.peek() === 'restore' ? meet(isDeleted) : null) ?? meet(this.seen);
  }

  /** The label under the cursor, 0 where there is none. */
  labelUnderCursor(): number {
    const hit = this.hit(0.03);
    const label = hit?.frame.labelOf(hit.point) ?? 0;
    return label === DELETED ? 0 : label;
  }

  roomPosition(hit: Hit): Vector3 {
    return new Vector3(...hit.position).applyMatrix4(this.viewer.room.matrixWorld);
  }

  /** The place under the cursor that is as far away as `pivot`, room coordinates. */
  ahead(pivot: Vector3): Vector3 {
    const { origin, direction } = this.ray();
    const distance = Math.max(1, this.viewer.camera.position.distanceTo(pivot));
    return new Vector3(...direction)
      .multiplyScalar(distance)
      .add(new Vector3(...origin))
      .applyMatrix4(this.viewer.room.matrixWorld);
  }

  /** Metres that a pixel takes at a distance. */
  pixelAt(distance: number): number {
    return this.viewer.camera.halfHeightAt(distance) / (this.canvas.clientHeight / 2);
  }

  /** Row-major `clip_from_source` of the picture on screen. */
  clipFromSource(info: SequenceInfo): number[] {
    const { camera, room } = this.viewer;
    const [x, y, z] = info.shift;
    return new Matrix4()
      .multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse)
      .multiply(room.matrixWorld)
      .multiply(new Matrix4().makeTranslation(-x, -y, -z))
      .transpose()
      .toArray();
  }
}
