/** The place of a large frame that one looks at: there it is predicted. */
import { Box3, Matrix4, Ray, Vector3, type Camera, type Object3D } from 'three';
import type { CloudFrame } from '../cloud/points/frame';

const ray = new Ray();
const box = new Box3();
const hit = new Vector3();

/**
 * Middle of the finest chunk that is met by the ray through the middle of the picture, local
 * coordinates; chunks are the finer, the nearer one looks.  Undefined: none is met.
 */
export function lookedAt(
  frame: CloudFrame,
  camera: Camera,
  room: Object3D,
): [number, number, number] | undefined {
  ray.origin.setFromMatrixPosition(camera.matrixWorld);
  camera.getWorldDirection(ray.direction);
  ray.applyMatrix4(new Matrix4().copy(room.matrixWorld).invert());
  let best: { level: number; distance: number; middle: Vector3 } | undefined;
  for (const { level, lo, hi } of frame.pieces) {
    box.min.fromArray(lo);
    box.max.fromArray(hi);
    if (!ray.intersectBox(box, hit)) continue;
    const distance = ray.origin.distanceTo(hit);
    if (best && (level < best.level || (level === best.level && distance >= best.distance)))
      continue;
    best = { level, distance, middle: box.getCenter(new Vector3()) };
  }
  return best?.middle.toArray();
}
