import { Matrix4, Quaternion, Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import { kindOf } from './kinds';
import { palmFacing, pinchesForSystem } from './palm';
import { Pointer } from './pointer';
import { Poses } from './poses';
import { BASE, TestSource } from '../testing/sources';

const EYES = { headInRig: new Vector3(0, 1.6, 0), gaze: new Vector3(0, -0.3, -1).normalize() };
const BESIDE = new Vector3(0.5, 1.6, -0.1);
const BEFORE = new Vector3(0.1, 1.4, -0.45);

/** The grip of a right hand at a place, its palm to the eyes, or its back. */
function hand(at: Vector3, palm: boolean): Matrix4 {
  const way = at.clone().sub(EYES.headInRig).normalize();
  const turn = new Quaternion().setFromUnitVectors(new Vector3(1, 0, 0), palm ? way : way.negate());
  return new Matrix4().makeRotationFromQuaternion(turn).setPosition(at);
}

describe('a palm', () => {
  it('that faces the eyes is told from the back of a hand, on either side', () => {
    const eyes = new Vector3(0, 1.6, 0);
    const up = new Matrix4().makeRotationZ(Math.PI / 2).setPosition(0, 1.2, 0);
    expect(palmFacing(up, 'left', eyes)).toBeCloseTo(1);
    expect(palmFacing(up, 'right', eyes)).toBeCloseTo(-1);
    const level = new Matrix4().setPosition(0, 1.2, 0);
    expect(palmFacing(level, 'left', eyes)).toBeCloseTo(0);
  });

  it('turned to the eyes that look at it pinches for the system', () => {
    expect(pinchesForSystem(hand(BEFORE, true), 'right', EYES)).toBe(true);
    expect(pinchesForSystem(hand(BEFORE, false), 'right', EYES)).toBe(false);
    // One that paints beside the head faces it as well.
    expect(pinchesForSystem(hand(BESIDE, true), 'right', EYES)).toBe(false);
  });
});

describe('a pinch', () => {
  const source = new TestSource({ hand: true });
  const kind = kindOf(source.xr)!;
  const poses = new Poses({} as unknown as XRSpace);
  const pointer = new Pointer(source.xr, kind, 0, true, poses.add(source.xr));

  /** One picture with the hand so; `pinched`: its fingers meet. */
  const see = (palm: boolean, pinched: boolean): number => {
    const { elements } = hand(BEFORE, palm);
    const matrix = new Float32Array(elements);
    const frame = { getPose: () => ({ transform: { matrix } }) } as unknown as XRFrame;
    poses.read(frame, BASE);
    pointer.select(pinched);
    pointer.update(poses, new Matrix4(), EYES);
    return pointer.trigger;
  };

  it('of a turned palm is the system’s until it is let go; another one paints, however it turns', () => {
    expect([see(true, false), see(true, true), see(false, true)]).toEqual([0, 0, 0]);
    expect([see(false, false), see(false, true), see(true, true)]).toEqual([0, 1, 1]);
  });
});
