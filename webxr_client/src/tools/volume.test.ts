import { Matrix4, Ray, Vector3 } from 'three';
import { expect, test } from 'vitest';
import { dragged, matrixOf, placeOf, spanned, standing, toSource, type Volume } from './volume';

const BOX: Volume = { center: [1, 2, 3], size: [2, 4, 6], yaw: Math.PI / 6 };

/** From above and aside, towards a place. */
function rayTo(place: Vector3): Ray {
  const origin = new Vector3(9, 12, 11);
  return new Ray(origin, place.clone().sub(origin).normalize());
}

test('a face follows the pointer along its axis, and the one across from it stays', () => {
  const face = { axis: 0, side: -1 } as const;
  const at = placeOf(BOX, face);
  const across = placeOf(BOX, { axis: 0, side: 1 });
  const out = at.clone().sub(across).normalize();
  const grown = dragged(BOX, face, rayTo(at), rayTo(at.clone().addScaledVector(out, 1.5)));
  expect(grown.size[0]).toBeCloseTo(3.5);
  expect(placeOf(grown, { axis: 0, side: 1 }).distanceTo(across)).toBeLessThan(1e-6);
  // Past the face across from it a box is thin, never inside out.
  const thin = dragged(BOX, face, rayTo(at), rayTo(at.clone().addScaledVector(out, -9)));
  expect(thin.size[0]).toBeGreaterThan(0);
});

test('the middle moves over the floor, and the knob turns about the upright axis', () => {
  const at = placeOf(BOX, 'move');
  const moved = dragged(BOX, 'move', rayTo(at), rayTo(at.clone().add(new Vector3(2, 0, -1))));
  moved.center.forEach((value, k) => expect(value).toBeCloseTo([3, 2, 2][k]!));
  const knob = placeOf(BOX, 'turn');
  const quarter = knob.clone().sub(at).applyAxisAngle(new Vector3(0, 1, 0), Math.PI / 2).add(at); // prettier-ignore
  const turned = dragged(BOX, 'turn', rayTo(knob), rayTo(quarter));
  expect(turned.yaw).toBeCloseTo(BOX.yaw + Math.PI / 2);
  expect(placeOf(turned, 'turn').distanceTo(quarter)).toBeLessThan(1e-6);
});

test('the wire has the same box in the coordinates of the recording', () => {
  const room = new Matrix4().makeRotationX(-Math.PI / 2).setPosition(0, 1.2, 0);
  const { center, size, quaternion } = toSource(BOX, room, [100, 200, 300]);
  const corner = new Vector3(1, -1, 1).applyMatrix4(matrixOf(BOX));
  const source = corner.applyMatrix4(room.clone().invert()).add(new Vector3(100, 200, 300));
  const [x, y, z, w] = quaternion;
  const back = source.sub(new Vector3(...center));
  back.applyQuaternion({ x: -x, y: -y, z: -z, w });
  back.toArray().forEach((value, k) => expect(value).toBeCloseTo(([1, -1, 1][k]! * size[k]!) / 2));
});

test('a box spans a rectangle on the floor as the eye sees it, and stands on the ground', () => {
  const [a, b] = [new Vector3(0, 0, 0), new Vector3(2, 0, 2)];
  const { center, size } = spanned(a, b, Math.PI / 4, 0.1, 1);
  expect(center).toEqual([1, 0.6, 1]);
  expect(size[0] * size[0] + size[2] * size[2]).toBeCloseTo(8);
  const low = standing(BOX, -1);
  expect([low.center[1], low.size[1]]).toEqual([1.5, 5]);
});
