import { Object3D, Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import { faceEyes } from './facing';

/** Move a place of the object to its parent's space. */
const placeOf = (object: Object3D, x: number, y: number, z: number): Vector3 =>
  new Vector3(x, y, z).applyMatrix4(object.matrix);

describe('what faces the eyes', () => {
  const at = new Vector3(-0.2, 1.1, -0.4);
  const eyes = new Vector3(0.05, 1.6, 0.1);

  it('is turned to them, upright, wherever it stands beside its place', () => {
    const object = new Object3D();
    faceEyes(object, at, eyes, { right: 0.07, up: 0.2, distance: 9 });
    const middle = placeOf(object, 0, 0, 0);
    const out = placeOf(object, 0, 0, 1).sub(middle);
    expect(out.length()).toBeCloseTo(1, 6);
    expect(out.angleTo(eyes.clone().sub(middle))).toBeLessThan(1e-5);
    const right = placeOf(object, 1, 0, 0).sub(middle);
    const up = placeOf(object, 0, 1, 0).sub(middle);
    expect(right.y).toBeCloseTo(0, 6);
    expect(up.y).toBeGreaterThan(0);
    expect(right.clone().cross(up).distanceTo(out)).toBeLessThan(1e-5);
    // Above its place and to the right, as the eyes see it.
    expect(middle.distanceTo(at)).toBeCloseTo(Math.hypot(0.07, 0.2), 6);
    expect(middle.y).toBeGreaterThan(at.y + 0.1);
  });

  it.each([0.3, 0.55, 0.8, 3])(
    'is never seen smaller than at its own distance: %f m',
    (distance) => {
      const object = new Object3D();
      const from = new Vector3(0, 1.5, 0);
      faceEyes(object, from, new Vector3(0, 1.5, distance), { right: 0, up: 0, distance: 0.55 });
      const height = placeOf(object, 0, 0.01, 0).y - from.y;
      expect(height / distance).toBeGreaterThanOrEqual(0.01 / 0.55 - 1e-9);
      if (distance < 0.55) expect(height).toBeCloseTo(0.01, 9);
    },
  );
});
