/** Things that turn to the eyes, and grow when they are far so that they can still be read. */
import type { Object3D, Vector3 } from 'three';

export interface Facing {
  /** Metres to the right and up from the place, as the eyes see it. */
  readonly right: number;
  readonly up: number;
  /** Metres at which it has its own size; farther away it grows. */
  readonly distance: number;
}

/**
 * Turn an object to the eyes; `at` and `eyes` are in its parent's space.  Numbers stay in registers,
 * where three's own `lookAt` would box some for each call.
 */
export function faceEyes(object: Object3D, at: Vector3, eyes: Vector3, facing: Facing): void {
  let { x, y, z } = at;
  const m = object.matrix.elements;
  // Moved aside it is turned once more: from there the eyes are elsewhere.
  for (let pass = 0; pass < 2; pass++) {
    const a = eyes.x - x;
    const b = eyes.y - y;
    const c = eyes.z - z;
    const eyeDistance = Math.max(1e-6, Math.sqrt(a * a + b * b + c * c));
    const level = Math.max(1e-6, Math.sqrt(a * a + c * c));
    const grown = Math.max(1, eyeDistance / facing.distance);
    // Its own axes, as columns: to the right, up, and to the eyes.
    m[0] = (grown * c) / level;
    m[2] = (-grown * a) / level;
    m[4] = (-grown * b * a) / (level * eyeDistance);
    m[5] = (grown * level) / eyeDistance;
    m[6] = (-grown * b * c) / (level * eyeDistance);
    m[8] = (grown * a) / eyeDistance;
    m[9] = (grown * b) / eyeDistance;
    m[10] = (grown * c) / eyeDistance;
    if (pass > 0) break;
    x += facing.right * m[0] + facing.up * m[4];
    y += facing.up * m[5];
    z += facing.right * m[2] + facing.up * m[6];
  }
  m[1] = 0;
  m[12] = x;
  m[13] = y;
  m[14] = z;
  object.matrixAutoUpdate = false;
  object.matrixWorldNeedsUpdate = true;
}
