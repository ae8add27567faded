import { Matrix4, Quaternion, Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import type { ObjectBox, Triple } from '../store/boxes';
import { near } from './testing';
import {
  between,
  BOX_VIEWS,
  carried,
  draggedIn,
  drawnAround,
  drawnPose,
  patchOf,
  placeOn,
  shapeIn,
  stretched,
  turned,
  type Shape,
  type ViewHandle,
} from './shape';

const YAW = new Quaternion().setFromAxisAngle(new Vector3(0, 0, 1), 0.6);
const CAR: Shape = {
  size: [4, 2, 1.5],
  centre: [500_000, 20, -1],
  quaternion: [YAW.x, YAW.y, YAW.z, YAW.w],
};
const [TOP, SIDE, FRONT] = BOX_VIEWS as [never, never, never];

function boxOf(...centres: Triple[]): ObjectBox {
  const { quaternion } = CAR;
  const pose = (centre: Triple) => drawnPose({ centre, quaternion });
  const poses = Object.fromEntries(centres.map((centre, i) => [i, pose(centre)]));
  return {
    id: 1,
    label: 1,
    size: CAR.size,
    poses,
    attributes: {},
    provenance: 'drawn',
    heading_known: true,
  };
}

describe('a side or corner that is dragged', () => {
  it('leaves the side across from it where it is, however the box is turned', () => {
    const longer = stretched(CAR, [1, 0, 0], [0.7, 0, 0]);
    expect(longer.size[0]).toBeCloseTo(4.7);
    near(placeOn(longer, [-1, 0, 0]), placeOn(CAR, [-1, 0, 0]));
  });

  it('leaves the corner across from a corner where it is', () => {
    const corner: ViewHandle = { right: -1, up: 1 };
    const wider = draggedIn(TOP, corner, CAR, [-2, 1], [-2.5, 1.3]);
    near(wider.size, [4.5, 2.3, 1.5]);
    near(placeOn(wider, [1, -1, 0]), placeOn(CAR, [1, -1, 0]));
  });

  it('does not turn the box inside out', () => {
    const flat = draggedIn(SIDE, { right: 0, up: 1 }, CAR, [0, 0.75], [0, -9]);
    expect(flat.size[2]).toBe(0.05);
    near(placeOn(flat, [0, 0, -1]), placeOn(CAR, [0, 0, -1]));
  });
});

describe('the knob', () => {
  it('turns the box as it goes round on screen, in each view', () => {
    const quarter = (view: never): Shape => draggedIn(view, 'turn', CAR, [1, 0], [0, 1]);
    const forward = (shape: Shape): Triple => {
      const [x, y, z] = placeOn(shape, [1, 0, 0]);
      return [x - shape.centre[0], y - shape.centre[1], z - shape.centre[2]];
    };
    // From above to the left, from the side upward; from ahead forward stays forward.
    near(forward(quarter(TOP)), [-2 * Math.sin(0.6), 2 * Math.cos(0.6), 0]);
    near(forward(quarter(SIDE)), [0, 0, 2]);
    near(forward(quarter(FRONT)), forward(CAR));
  });
});

describe('a new size', () => {
  it('counts in every frame, and leaves the same side where it is in each', () => {
    const box = boxOf(CAR.centre, [500_010, 22, -1]);
    const before = shapeIn(box, 0)!;
    const after = stretched(before, [-1, 0, 0], [-1, 0, 0]);
    const { size, poses } = patchOf(box, 0, before, after);
    expect(size![0]).toBeCloseTo(5);
    const other = { ...shapeIn(box, 1)!, ...poses!['1']!, size: size! };
    near(placeOn(other, [1, 0, 0]), placeOn(shapeIn(box, 1)!, [1, 0, 0]));
  });

  it('is no business of a box that only moved', () => {
    const box = boxOf(CAR.centre, CAR.centre);
    const patch = patchOf(box, 0, CAR, turned(CAR, 2, 0.1));
    expect(patch.size).toBeUndefined();
    expect(Object.keys(patch.poses!)).toEqual(['0']);
  });
});

describe('poses in other frames', () => {
  it('lie between two drawn ones, turning the shorter way', () => {
    const end = { ...turned(CAR, 2, -0.4), centre: [500_008, 24, -1] as Triple };
    const middle = between(CAR, end, 0.5);
    near(middle.centre, [500_004, 22, -1]);
    near(middle.quaternion, turned(CAR, 2, -0.2).quaternion);
  });

  it('go along with the frame', () => {
    const T = new Matrix4().makeRotationZ(Math.PI / 2).setPosition(1, 2, 3);
    near(carried({ ...CAR, centre: [4, 0, 0] }, T).centre, [1, 6, 3]);
  });

  it('are found between the drawn ones around a frame', () => {
    const box = boxOf(CAR.centre, CAR.centre, CAR.centre, CAR.centre);
    const fitted = { ...box.poses['1']!, provenance: 'fitted' as const };
    const some = { ...box, poses: { ...box.poses, 1: fitted, 2: fitted } };
    expect(drawnAround(some, 1)).toEqual([0, 3]);
    expect(drawnAround(some, 3)).toEqual([0, 3]);
    expect(drawnAround(boxOf(CAR.centre), 0)).toBeNull();
  });
});
