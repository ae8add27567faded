import { PerspectiveCamera, Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import { holds, insideOutline, type Outline } from './inside';
import { frameOf, wall } from './testing';

function clipOf(camera: PerspectiveCamera): number[] {
  camera.updateMatrixWorld();
  return camera.projectionMatrix.clone().multiply(camera.matrixWorldInverse).transpose().toArray();
}

function lookingAtWall(): PerspectiveCamera {
  const camera = new PerspectiveCamera(55, 1, 0.05, 100);
  camera.position.set(0.2, 0.2, -1);
  camera.lookAt(0.2, 0.2, 1);
  return camera;
}

const SQUARE: Outline = [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]]; // prettier-ignore

describe('points inside an outline', () => {
  it('are those that the camera sees there, whatever is culled', () => {
    const points = wall(40, 1000);
    const frame = frameOf(points);
    const camera = lookingAtWall();
    const found: number[] = [];
    insideOutline(frame, SQUARE, clipOf(camera), (point) => found.push(point));
    const expected = points.flatMap(([x, y, z], i) => {
      const at = new Vector3(x, y, z).multiplyScalar(0.001).project(camera);
      return Math.abs(at.x) < 0.1 && Math.abs(at.y) < 0.1 ? [i] : [];
    });
    expect(found).toEqual(expected);
    expect(found.length).toBeGreaterThan(20);
  });

  it('are none behind the camera', () => {
    const camera = lookingAtWall();
    camera.position.z = 2;
    camera.lookAt(0.2, 0.2, 3);
    const found: number[] = [];
    insideOutline(frameOf(wall(40, 1000)), SQUARE, clipOf(camera), (point) => found.push(point));
    expect(found).toEqual([]);
  });
});

it('leaves out what an outline goes round twice', () => {
  const star: Outline = [[0, 1], [0.6, -0.8], [-0.95, 0.3], [0.95, 0.3], [-0.6, -0.8]]; // prettier-ignore
  expect(holds(star, 0, 0)).toBe(false);
  expect(holds(star, 0, 0.6)).toBe(true);
});
