import { DataTexture, Matrix4, Object3D } from 'three';
import { afterEach, describe, expect, it } from 'vitest';
import { clip, clipInRoom } from '../tools/clip';
import { type CloudFrame } from '../cloud/points/frame';
import { PointUniforms } from '../cloud/picture/material';
import { frameOf } from '../cloud/points/testing';
import type { SequenceInfo } from '../protocol/messages';
import { state } from '../store/state';
import { Boxes } from './boxes';
import { Summaries } from './summary';
import { Trails } from './trails';

const ROOM = new Matrix4().makeTranslation(10, 0, -5);
const LABEL = 1;

/** A cube of eight points, 200 mm wide, so many metres along x; all have the label. */
function cube(metres: number): CloudFrame {
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((bits): [number, number, number] => [
    1000 * metres + 200 * (bits & 1), 100 * (bits & 2), 50 * (bits & 4),
  ]); // prettier-ignore
  const frame = frameOf(corners);
  frame.pieces[0]!.labels = new Uint16Array(8).fill(LABEL);
  return frame;
}

afterEach(() => {
  clip.value = null;
  state.sequence.value = null;
  state.palette.value = [];
});

describe('what is drawn over a recording with a clip box', () => {
  it('is left out where it lies outside', () => {
    const rows = ROOM.clone().transpose().elements;
    state.sequence.value = { room: rows, shift: [300, 0, 0] } as unknown as SequenceInfo;
    const look = { name: 'cup', category: '', color: '#ff0000', locked: false, visible: true };
    state.palette.value = [{ id: LABEL, ...look }];
    const summaries = new Summaries();
    const found = [0, 1, 2, 3, 4].map((metres) => summaries.of(cube(metres), ROOM, 0));
    const world = new Object3D();
    const trails = new Trails(world, new PointUniforms(new DataTexture()));
    const boxes = new Boxes(world);
    const draw = (): void => {
      const known = (frame: number) => found[frame] ?? null;
      trails.show(2, found.length, state.palette.value, known, clipInRoom.value);
      boxes.show(found[2]!, clipInRoom.value);
    };
    const lines = (): number => trails.lines.geometry.drawRange.count / 2;
    draw();
    expect([trails.count, lines(), boxes.count]).toEqual([5, 4, 1]);

    // Round the objects of frames 1 and 2, in the room.
    const volume = { center: [11.6, 0, -5], size: [1.4, 2, 2], yaw: 0 } as const;
    clip.value = { volume, slab: null, follows: false };
    draw();
    expect([trails.count, lines(), boxes.count]).toEqual([2, 1, 1]);

    clip.value = { ...clip.value, volume: { ...clip.value.volume, center: [20, 0, -5] } };
    draw();
    expect([trails.count, lines(), boxes.count]).toEqual([0, 0, 0]);
  });
});
