import { expect, it } from 'vitest';
import { Matrix4, PerspectiveCamera } from 'three';
import type { DepthImage } from '../../../net/chunk/segment';
import type { SurfaceMode } from '../../../store/types';
import { SurfaceChoice } from './surface-choice';

const SIDE = 200;
/** A wall two metres before a camera at the origin; its points are 11.5 mm apart. */
const IMAGE: DepthImage = {
  sensor: 0,
  mount: null,
  lattice: {
    width: SIDE,
    height: SIDE,
    axis: 2,
    sign: -1,
    tangent: [-0.5, -0.5],
    pitch: [0.005, 0.005],
    eye: [0, 0, 0],
    unit: 0.001,
  },
  depths: new Uint16Array(SIDE * SIDE).fill(2000),
  colours: null,
};

function chosen(
  mode: SurfaceMode,
  metres: number,
  images: readonly DepthImage[] = [IMAGE],
): boolean {
  const choice = new SurfaceChoice();
  choice.mode = mode;
  const camera = new PerspectiveCamera(60, 1, 0.05, 100);
  camera.position.z = metres - 2;
  camera.updateMatrixWorld();
  return choice.update(images, camera, new Matrix4(), 720);
}

it('draws a surface by itself where its points would show gaps', () => {
  expect(chosen('auto', 1)).toBe(true);
  expect(chosen('auto', 6)).toBe(false);
});

it('draws what was asked for, but points where there is no depth image', () => {
  expect(chosen('surface', 6)).toBe(true);
  expect(chosen('points', 1)).toBe(false);
  expect(chosen('surface', 1, [])).toBe(false);
  expect(chosen('auto', 1, [])).toBe(false);
});
