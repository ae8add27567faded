import { Matrix4, Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import { CloudFrame } from '../cloud/points/frame';
import { frameAround } from '../cloud/points/testing';
import { viewOf } from './framing';

type Vector = [number, number, number];

const camera = Array.from({ length: 400 }, (_, i): Vector => [
  ((i % 20) - 10) * 100,
  (Math.floor(i / 20) - 10) * 100,
  -3000,
]);
const ring = Array.from({ length: 400 }, (_, i): Vector => {
  const radius = 2000 + (i % 40) * 500;
  return [Math.round(radius * Math.cos(i)), -1500, Math.round(radius * Math.sin(i))];
});

const LOCAL = [0, 0, 0];

describe('the first view', () => {
  it('is that of a camera which saw the points from the origin', () => {
    const frame = frameAround(camera);
    const view = viewOf('sensor', frame, new Matrix4(), 55, 1.6, LOCAL)!;
    expect(view.eye.length()).toBeLessThan(0.2);
    expect(
      view.target
        .clone()
        .normalize()
        .dot(new Vector3(0, 0, -1)),
    ).toBeGreaterThan(0.99);
  });

  it('is from above and behind a lidar', () => {
    const frame = frameAround(ring);
    const view = viewOf('sensor', frame, new Matrix4(), 55, 1.6, LOCAL)!;
    expect(view.eye.y).toBeGreaterThan(3);
    expect(view.target.length()).toBeLessThan(1e-6);
  });

  it('looks down on a scan in the coordinates of a map, whose local origin is no sensor', () => {
    const frame = frameAround(ring);
    const aside = new Matrix4().makeTranslation(30, 0, 30);
    const { eye, target } = viewOf('sensor', frame, aside, 55, 1.6, [448300, 5411900, 0])!;
    expect(target.x).toBeGreaterThan(25);
    expect(eye.y).toBeGreaterThan(target.y + 5);
  });

  it('has everything in it when no sensor is at the origin', () => {
    const frame = frameAround(camera);
    const far = new Matrix4().makeTranslation(500, 0, 0);
    const view = viewOf('fit', frame, far, 55, 1.6, LOCAL)!;
    expect(view.target.distanceTo(new Vector3(500, 0, -3))).toBeLessThan(0.2);
    expect(view.eye.distanceTo(view.target)).toBeGreaterThan(1.5);
  });

  it('from the top looks down', () => {
    const frame = frameAround(ring);
    const { eye, target } = viewOf('top', frame, new Matrix4(), 55, 1.6, LOCAL)!;
    expect(target.clone().sub(eye).normalize().y).toBeLessThan(-0.99);
  });

  const overhead = camera.map(([x, y, z]): Vector => [x, y + 3000, z]);
  it.each([
    ['one point', [overhead[0]!]],
    ['two points', overhead.slice(0, 2)],
    ['points above the origin', overhead],
  ])('looks down on %s, never from below', (_, points) => {
    const frame = frameAround(points);
    const { eye, target } = viewOf('sensor', frame, new Matrix4(), 55, 1.6, LOCAL)!;
    expect(eye.y).toBeGreaterThan(target.y + 0.1);
    expect(target.y).toBeCloseTo(points.length > 2 ? 3 : 2, 0);
  });

  it('looks down on a point at the height of the sensor', () => {
    const frame = frameAround([[0, 0, 3000]]);
    expect(viewOf('sensor', frame, new Matrix4(), 55, 1.6, LOCAL)!.eye.y).toBeGreaterThan(0.1);
  });

  it('needs points', () => {
    expect(viewOf('fit', new CloudFrame(0, false), new Matrix4(), 55, 1.6, LOCAL)).toBeNull();
  });
});
