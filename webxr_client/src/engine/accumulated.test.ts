import { Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import type { SequenceInfo } from '../protocol/messages';
import { localMatrix, MOST_POINTS, wanted } from './accumulated';

function recording(points: number[]): SequenceInfo {
  return { frames: points.length, points } as SequenceInfo;
}

describe('frames around one', () => {
  it('are the nearest first, as far as there are any', () => {
    const info = recording([9, 9, 0, 9, 9, 9]);
    expect(wanted(info, 3, 5, 1)).toEqual({ frames: [4, 1, 0], left: 0 });
    expect(wanted(info, 0, 2, 2)).toEqual({ frames: [1], left: 0 });
  });

  it('are left out where one picture cannot hold them', () => {
    const large = MOST_POINTS / 4;
    const info = recording(Array.from({ length: 9 }, () => large));
    expect(wanted(info, 4, 4, 4)).toEqual({ frames: [5, 3, 6], left: 5 });
  });

  it('are placed far from the origin as near to it', () => {
    const shift = [500_000, 4_600_000, 200];
    // A quarter turn about the recording's own origin, and a metre up.
    const rows = [0, -1, 0, shift[0]! + shift[1]!, 1, 0, 0, shift[1]! - shift[0]!, 0, 0, 1, 1, 0, 0, 0, 1]; // prettier-ignore
    const T = localMatrix(rows, shift);
    expect(new Vector3(2, 3, 4).applyMatrix4(T).toArray()).toEqual([-3, 2, 5]);
  });
});
