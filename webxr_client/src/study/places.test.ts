import { Euler, Matrix4, Quaternion, Vector3 } from 'three';
import { expect, it } from 'vitest';
import { movedPose, sourceFrom } from './places';

it('logs a pose that leads back to the same place of the room, however the room was moved', () => {
  const room = new Matrix4().makeRotationX(-Math.PI / 2).setPosition(0, 1.2, 0);
  const moved = new Matrix4().compose(
    new Vector3(3, 0.5, -2),
    new Quaternion().setFromEuler(new Euler(0, 0.7, 0)),
    new Vector3(0.25, 0.25, 0.25),
  );
  const inOwnRoom = new Vector3(0.4, 1.6, -0.3);
  const turned = new Quaternion().setFromEuler(new Euler(0.2, -0.4, 0.1));
  const scene = inOwnRoom.clone().applyMatrix4(moved);
  const sceneTurn = new Quaternion().setFromEuler(new Euler(0, 0.7, 0)).multiply(turned);
  const shift = [1000, 2000, 30] as const;
  const logged = movedPose(sourceFrom(moved.clone().multiply(room), shift), [
    ...scene.toArray(),
    ...sceneTurn.toArray(),
  ]);
  expect(logged[0]).toBeGreaterThan(999);
  const back = movedPose(sourceFrom(room, shift).invert(), logged);
  [...inOwnRoom.toArray(), ...turned.toArray()].forEach((value, i) =>
    expect(back[i]).toBeCloseTo(value, 4),
  );
});
