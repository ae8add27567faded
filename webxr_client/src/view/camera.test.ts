import { Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import { Lens } from '../cloud/picture/lens';
import { DeskCamera } from './camera';

function setUp(): DeskCamera {
  const lens = new Lens(55, 1.5, 0.05, 500);
  const camera = new DeskCamera(lens);
  camera.lookAt(new Vector3(0, 3, 4), new Vector3(0, 0, 0), true);
  camera.update(0);
  return camera;
}

/** Return the place of a point on screen, −1..1. */
function onScreen(camera: DeskCamera, ...place: [number, number, number]): Vector3 {
  camera.camera.updateMatrixWorld();
  return new Vector3(...place).project(camera.camera);
}

describe('an orthographic picture', () => {
  it('looks straight down, to one scale at every depth, and shows what is tall', () => {
    const camera = setUp();
    camera.depth = 40;
    camera.lookAt(new Vector3(0, 10, 0), new Vector3(0, 0, 0), true, true);
    camera.update(0);
    const low = onScreen(camera, 1, 0, 0);
    const high = onScreen(camera, 1, 20, 0);
    expect(high.x).toBeCloseTo(low.x, 6);
    expect(Math.abs(high.z)).toBeLessThan(1);
    expect(onScreen(camera, 0, 0, -1).y).toBeGreaterThan(0.05);
  });

  it('keeps the pivot in place and in size when it is turned on and off', () => {
    const camera = setUp();
    const before = onScreen(camera, 0.3, 0, 0);
    camera.toggleOrthographic();
    expect(onScreen(camera, 0, 0, 0).length()).toBeLessThan(1);
    expect(onScreen(camera, 0.3, 0, 0).x).toBeCloseTo(before.x, 6);
    camera.turn(40, 10);
    camera.toggleOrthographic();
    expect(camera.camera.position.length()).toBeCloseTo(5, 5);
    expect(onScreen(camera, 0, 0, 0).x).toBeCloseTo(0, 6);
  });

  it('zooms to the place under the cursor', () => {
    const camera = setUp();
    camera.toggleOrthographic();
    const before = onScreen(camera, 0.4, 0.2, 0);
    camera.zoom(3, new Vector3(0.4, 0.2, 0));
    const after = onScreen(camera, 0.4, 0.2, 0);
    expect(after.x).toBeCloseTo(before.x, 6);
    expect(after.y).toBeCloseTo(before.y, 6);
    expect(onScreen(camera, 0, 0, 0).x).toBeLessThan(-0.01);
  });

  it('comes back to a view that was kept, in either kind', () => {
    const camera = setUp();
    camera.toggleOrthographic();
    const kept = camera.view;
    const before = onScreen(camera, 0.4, 0.2, 0);
    camera.lookAt(new Vector3(9, 1, 0), new Vector3(0, 0, 0), true);
    camera.update(0);
    expect(camera.camera.orthographic).toBe(false);
    camera.restore(kept);
    camera.turn(0, 0);
    expect(camera.camera.orthographic).toBe(true);
    camera.restore(kept);
    camera.restore(kept);
    expect(onScreen(camera, 0.4, 0.2, 0).distanceTo(before)).toBeLessThan(1);
  });
});

describe('the keys that walk', () => {
  it('rise and sink with E and Q, whatever one looks at', () => {
    const camera = setUp();
    const { position } = camera.camera;
    const before = position.clone();
    camera.key('e', true);
    camera.update(0);
    camera.update(50);
    expect(position.y).toBeGreaterThan(before.y);
    expect(position.x).toBeCloseTo(before.x, 9);
    expect(position.z).toBeCloseTo(before.z, 9);
    camera.key('e', false);
    expect(camera.update(100)).toBe(false);
  });

  it('go closer to an object without turning', () => {
    const camera = setUp();
    const turn = camera.camera.quaternion.clone();
    camera.approach(new Vector3(1, 1, 1), 0.5);
    expect(camera.view.target).toEqual([1, 1, 1]);
    expect(camera.camera.quaternion.angleTo(turn)).toBeLessThan(1e-6);
    expect(new Vector3(...camera.view.eye).distanceTo(new Vector3(1, 1, 1))).toBeCloseTo(0.96, 2);
  });
});
