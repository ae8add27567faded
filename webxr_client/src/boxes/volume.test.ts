import { Matrix4, Ray, Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import { dragged, placeOf } from '../tools/volume';
import { placeOn, turned, type Shape } from './shape';
import { distanceTo, lengthwise, shapeOf, volumeOf } from './volume';
import { near } from './testing';

/** z up in the source, y up in the room, two metres lower. */
const ROOM = new Matrix4().makeRotationX(-Math.PI / 2).setPosition(0, -2, 0);
const SHIFT = [500_000, 0, 0] as const;
const CAR: Shape = turned(
  { size: [4, 2, 1.5], centre: [500_010, 5, 1], quaternion: [0, 0, 0, 1] },
  2,
  0.5,
);

describe('a box in the room', () => {
  it('stands there as it does in the frame, and comes back the same', () => {
    for (const shape of [CAR, turned(CAR, 1, 0.2)]) {
      const volume = volumeOf(shape, ROOM, SHIFT);
      const back = shapeOf(volume, ROOM, SHIFT);
      near(volume.center, [10, -1, -5]);
      near(back.size, shape.size);
      near(placeOn(back, [1, 1, 1]), placeOn(shape, [1, 1, 1]));
    }
    const upright = volumeOf(CAR, ROOM, SHIFT);
    expect(upright.tilt).toBeUndefined();
    near(placeOf(upright, { axis: 1, side: 1 }).toArray(), [10, -0.25, -5]);
  });

  it('is longer once its front is dragged, and its back stays', () => {
    const volume = volumeOf({ ...CAR, quaternion: [0, 0, 0, 1] }, ROOM, SHIFT);
    const ray = (x: number): Ray => new Ray(new Vector3(x, 9, -5), new Vector3(0, -1, 0));
    const longer = shapeOf(dragged(volume, { axis: 0, side: 1 }, ray(12), ray(13)), ROOM, SHIFT);
    near(longer.size, [5, 2, 1.5]);
    near(placeOn(longer, [-1, 0, 0]), [500_008, 5, 1]);
  });

  it('has its longer side forward', () => {
    const { size } = lengthwise({ center: [0, 0, 0], size: [2, 1.5, 4], yaw: 0 });
    expect(size).toEqual([4, 1.5, 2]);
  });

  it('is met by a ray', () => {
    const [origin, way] = [new Vector3(500_010, 5, 9), new Vector3(0, 0, -1)];
    expect(distanceTo(CAR, origin, way)).toBeCloseTo(7.25);
    expect(distanceTo(CAR, origin.clone().setY(50), way)).toBeNull();
  });
});
