import { Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import { bonesOf, HandModel } from './hand-model';

const spaces = Array.from({ length: 25 }, (_, joint) => ({ joint }) as unknown as XRJointSpace);
const hand = { values: () => spaces.values() } as unknown as XRHand;

/** A frame in which each joint is seen, or none is. */
function frameOf(seen: boolean): XRFrame {
  const fillPoses = (_: unknown, _space: unknown, out: Float32Array): boolean => {
    for (let i = 0; i < 25; i++) out.set([i / 100, 1, -i / 50], 16 * i + 12);
    return seen;
  };
  const fillJointRadii = (_: unknown, out: Float32Array): boolean => {
    out.fill(0.009);
    return seen;
  };
  return { fillPoses, fillJointRadii } as unknown as XRFrame;
}

describe('a bare hand', () => {
  it('has skin from the wrist to every finger tip and across the palm', () => {
    const bones = bonesOf();
    const joined = new Set([0]);
    for (let round = 0; round < 25; round++) {
      for (const [a, b] of bones) if (joined.has(a)) joined.add(b);
    }
    expect(joined.size).toBe(25);
    // Knuckles of neighbouring fingers.
    for (const pair of [[6, 11], [11, 16], [16, 21]]) expect(bones).toContainEqual(pair); // prettier-ignore
  });

  it('is one mesh that follows the joints, and pinches between two tips', () => {
    const model = new HandModel(hand);
    const at = new Vector3();
    expect(model.pinch(at)).toBe(false);
    model.update(frameOf(true), {} as unknown as XRReferenceSpace);
    expect(model.mesh.children).toEqual([]);
    expect(model.pinch(at)).toBe(true);
    expect(at.x).toBeCloseTo((0.04 + 0.09) / 2);
    expect(model.fingertip(at)).toBe(true);
    expect(at.z).toBeCloseTo(-0.18);
    model.update(frameOf(false), {} as unknown as XRReferenceSpace);
    expect(model.mesh.visible).toBe(false);
    model.dispose();
  });
});
