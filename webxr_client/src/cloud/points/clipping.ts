/** Clip boxes, and tests for places inside. */
import { Matrix4, Quaternion, Vector3 } from 'three';
import type { ClipBox } from '../../protocol/messages';

/** `T_cube_local` of a box in source coordinates: inside is the cube of edges 2; `shift`: source minus local. */
export function cubeOf(box: ClipBox, shift: readonly [number, number, number]): Matrix4 {
  const center = new Vector3(...box.center).sub(new Vector3(...shift));
  const turn = new Quaternion(...(box.quaternion ?? [0, 0, 0, 1])).normalize();
  const half = new Vector3(...box.size).multiplyScalar(0.5);
  return new Matrix4().compose(center, turn, half).invert();
}

/** Return whether a place (local coordinates, or the room's for `T_cube_room`) is inside. */
export function shows({ elements: e }: Matrix4, x: number, y: number, z: number): boolean {
  return (
    Math.abs(e[0] * x + e[4] * y + e[8] * z + e[12]) <= 1 &&
    Math.abs(e[1] * x + e[5] * y + e[9] * z + e[13]) <= 1 &&
    Math.abs(e[2] * x + e[6] * y + e[10] * z + e[14]) <= 1
  );
}

/** Return whether a ball may reach inside: it does not lie wholly beyond one of the faces. */
export function reaches(
  { elements: e }: Matrix4,
  x: number,
  y: number,
  z: number,
  radius: number,
): boolean {
  for (let row = 0; row < 3; row++) {
    const [a, b, c] = [e[row]!, e[row + 4]!, e[row + 8]!];
    if (Math.abs(a * x + b * y + c * z + e[row + 12]!) > 1 + radius * Math.hypot(a, b, c))
      return false;
  }
  return true;
}
