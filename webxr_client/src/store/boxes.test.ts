import { beforeEach, describe, expect, it } from 'vitest';
import {
  boxes,
  chosenBox,
  expectChange,
  FOLLOWS,
  forgetBoxes,
  NONE,
  picked,
  takeBoxes,
  type BoxPose,
  type ObjectBox,
} from './boxes';
import { state } from './state';

const POSE: BoxPose = {
  centre: [1, 2, 3],
  quaternion: [0, 0, 0, 1],
  provenance: 'fitted',
  confidence: 0.8,
  attributes: {},
};

function box(id: number, label: number, length = 4): ObjectBox {
  const poses = { [id]: POSE };
  return {
    id,
    label,
    size: [length, 2, 1.5],
    poses,
    attributes: {},
    provenance: 'fitted',
    heading_known: true,
  };
}

function receive(revision: number, some: ObjectBox[], removed: number[] = [], whole = false): void {
  takeBoxes({ revision, boxes: some, removed, whole });
}

const lengthOf = (id: number): number | undefined => boxes.peek().get(id)?.size[0];

beforeEach(() => {
  forgetBoxes();
  state.activeLabel.value = 7;
  receive(1, [box(1, 7), box(2, 7), box(3, 8)], [], true);
});

describe('boxes', () => {
  it('are what the server told last', () => {
    receive(3, [box(1, 7, 5)], [2]);
    expect([...boxes.peek().keys()]).toEqual([1, 3]);
    receive(2, [box(1, 7, 4.5)]);
    expect(lengthOf(1)).toBe(5);
    receive(4, [box(9, 7)], [], true);
    expect([...boxes.peek().keys()]).toEqual([9]);
  });

  it('show a change before it is answered, whatever is told meanwhile', () => {
    const answered = expectChange(1, { size: [6, 2, 1.5], poses: { 1: null, 2: POSE } });
    expect(lengthOf(1)).toBe(6);
    expect(Object.keys(boxes.peek().get(1)!.poses)).toEqual(['2']);
    receive(2, [box(1, 7, 4.5)]);
    expect(lengthOf(1)).toBe(6);
    answered();
    expect(lengthOf(1)).toBe(4.5);
  });
});

describe('the chosen box', () => {
  it('is the active label’s in the frame, or the one that was picked', () => {
    state.frame.value = 2;
    expect(chosenBox.peek()?.id).toBe(2);
    picked.value = 1;
    expect(chosenBox.peek()?.id).toBe(1);
    state.activeLabel.value = 8;
    expect(chosenBox.peek()?.id).toBe(3);
    picked.value = NONE;
    expect(chosenBox.peek()).toBeNull();
    picked.value = FOLLOWS;
    state.activeLabel.value = 9;
    expect(chosenBox.peek()).toBeNull();
  });
});
