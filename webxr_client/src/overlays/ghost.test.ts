import { DataTexture, Object3D, type Points } from 'three';
import { expect, it } from 'vitest';
import { PointUniforms } from '../cloud/picture/material';
import { frameOf, wall } from '../cloud/points/testing';
import { state } from '../store/state';
import { Ghost, isGhostAllowed } from './ghost';

it('is grey and sparse, so that nobody takes it for labelled points', () => {
  const frame = frameOf(wall(100, 1000));
  frame.pieces[0]!.labels = new Uint16Array(10_000).fill(1);
  const look = { name: 'pin', category: '', color: '#ff0000', locked: false, visible: true };
  state.palette.value = [{ id: 1, ...look }];
  const room = new Object3D();
  const ghost = new Ghost(room, new PointUniforms(new DataTexture()));
  ghost.show(frame, 1);
  expect(ghost.count).toBeGreaterThan(500);
  expect(ghost.count).toBeLessThan(2000);
  const { color } = (room.children[0] as Points).geometry.attributes;
  for (let i = 0; i < ghost.count; i++) expect(color!.getX(i)).toBe(color!.getY(i));
});

it('is not there where labels are judged', () => {
  const view = { ghost: true, color: 'rgb' } as const;
  expect(isGhostAllowed(view, false, false)).toBe(true);
  expect(isGhostAllowed(view, true, false)).toBe(false);
  expect(isGhostAllowed(view, false, true)).toBe(false);
  for (const color of ['label', 'confidence', 'provenance'] as const)
    expect(isGhostAllowed({ ...view, color }, false, false)).toBe(false);
});
