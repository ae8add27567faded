import { PerspectiveCamera, Vector4 } from 'three';
import { describe, expect, it } from 'vitest';
import { farFor, NEAR, reverseDepth, reverseEyes, setPlanes } from './headset-depth';

const STREET = 500;

function eye(): PerspectiveCamera {
  const camera = new PerspectiveCamera(90, 1, NEAR, farFor(STREET));
  camera.updateProjectionMatrix();
  return camera;
}

/** Depth that the GPU computes, in its 32-bit floats, for a point `distance` metres ahead. */
function depth(camera: PerspectiveCamera, distance: number): number {
  const at = new Vector4(0, 0, -distance, 1).applyMatrix4(camera.projectionMatrix);
  return Math.fround(Math.fround(at.z) / Math.fround(at.w));
}

describe('depth in the headset', () => {
  it('begins at most 5 cm from the eyes, and ends behind the recording, however large', () => {
    const camera = new PerspectiveCamera();
    for (const size of [0.3, 10, 250, 566, 5000]) {
      setPlanes(camera, size, false);
      expect(camera.near).toBeLessThanOrEqual(0.05);
      expect(camera.far).toBeGreaterThan(2 * size);
    }
  });

  it('is told to the session by swapped planes where it is reversed', () => {
    const camera = new PerspectiveCamera();
    setPlanes(camera, STREET, true);
    expect([camera.near, camera.far]).toEqual([farFor(STREET), NEAR]);
  });

  it('is the same from a session that took the swapped planes', () => {
    const withSwappedPlanes = new PerspectiveCamera(90, 1);
    setPlanes(withSwappedPlanes, STREET, true);
    withSwappedPlanes.updateProjectionMatrix();
    const unswapped = eye();
    for (const { projectionMatrix } of [withSwappedPlanes, unswapped])
      reverseDepth(projectionMatrix);
    for (const distance of [NEAR, 1, 30, 400, farFor(STREET)]) {
      expect(depth(withSwappedPlanes, distance)).toBeCloseTo(depth(unswapped, distance), 6);
    }
  });

  it('runs from 1 at the near plane to 0 at the far one', () => {
    const camera = eye();
    reverseDepth(camera.projectionMatrix);
    expect(depth(camera, NEAR)).toBeCloseTo(1, 6);
    expect(depth(camera, camera.far)).toBeCloseTo(0, 9);
    expect(depth(camera, 1)).toBeGreaterThan(depth(camera, 2));
  });

  it('tells apart at the end of a street what the usual depth cannot', () => {
    const [usual, reversed] = [eye(), eye()];
    reverseDepth(reversed.projectionMatrix);
    const distinctDepths = (camera: PerspectiveCamera): number =>
      new Set(Array.from({ length: 100 }, (_, cm) => depth(camera, 400 + cm / 100))).size;
    expect(distinctDepths(usual)).toBeLessThan(20);
    expect(distinctDepths(reversed)).toBe(100);
  });

  it('leaves where things are in the picture as the session says', () => {
    const camera = eye();
    const before = new Vector4(1, 2, -7, 1).applyMatrix4(camera.projectionMatrix);
    reverseEyes([camera]);
    const after = new Vector4(1, 2, -7, 1).applyMatrix4(camera.projectionMatrix);
    expect([after.x, after.y, after.w]).toEqual([before.x, before.y, before.w]);
    // three.js would replace the projection of a camera without this flag.
    expect(camera.reversedDepth).toBe(true);
    const back = after.applyMatrix4(camera.projectionMatrixInverse);
    expect(back.x / back.w).toBeCloseTo(1, 4);
  });
});
