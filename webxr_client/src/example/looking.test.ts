import { expect, it } from 'vitest';
import { Group, PerspectiveCamera } from 'three';
import type { CloudFrame } from '../cloud/points/frame';
import { lookedAt } from './looking';

const piece = (level: number, lo: number[], hi: number[]) => ({ level, lo, hi });

it('is the finest chunk ahead, the nearest of alike ones', () => {
  const frame = {
    pieces: [
      piece(0, [-50, -50, -50], [50, 50, 50]),
      piece(2, [-1, -1, -32], [1, 1, -30]),
      piece(2, [-1, -1, -12], [1, 1, -10]),
      piece(3, [4, -1, -12], [6, 1, -10]),
    ],
  } as unknown as CloudFrame;
  const camera = new PerspectiveCamera();
  const room = new Group();
  expect(lookedAt(frame, camera, room)).toEqual([0, 0, -11]);
  room.position.set(-5, 0, 0);
  room.updateMatrixWorld();
  expect(lookedAt(frame, camera, room)).toEqual([5, 0, -11]);
  camera.lookAt(0, 1000, 1);
  camera.updateMatrixWorld();
  expect(lookedAt({ pieces: [] } as unknown as CloudFrame, camera, room)).toBeUndefined();
});
