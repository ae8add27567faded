import { Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import { frameOf, wall } from '../cloud/testing';
import { middleOf } from './trail';

describe('the trail of an object', () => {
  it('goes through the middle of its points', () => {
    const frame = frameOf(wall(10, 50));
    const piece = frame.pieces[0]!;
    const out = new Vector3();
    expect(middleOf(frame, 3, out)).toBe(false);
    piece.labels = new Uint16Array(piece.count);
    piece.labels[0] = piece.labels[2] = 3;
    piece.labels[5] = 4;
    expect(middleOf(frame, 3, out)).toBe(true);
    const at = (i: number, k: 0 | 1 | 2): number =>
      piece.origin[k] + piece.words[6 * i + k]! * piece.scale[k];
    for (const k of [0, 1, 2] as const) {
      expect(out.getComponent(k)).toBeCloseTo((at(0, k) + at(2, k)) / 2, 6);
    }
  });
});
