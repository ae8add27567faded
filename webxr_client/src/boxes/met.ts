/** Boxes that rays meet. */
import type { Vector3 } from 'three';
import { boxes, type ObjectBox } from '../store/boxes';
import { state } from '../store/state';
import { shapeIn } from './shape';
import { distanceTo, lessShift } from './volume';

/** The box of the frame on screen that a ray (local coordinates) meets first, within metres. */
export function boxMet(origin: Vector3, direction: Vector3, within: number): ObjectBox | null {
  const shift = state.sequence.peek()?.shift ?? [0, 0, 0];
  const { frame } = state.shown.peek();
  let best: ObjectBox | null = null;
  let nearest = within;
  for (const box of boxes.peek().values()) {
    const shape = shapeIn(box, frame);
    const distance = shape && distanceTo(lessShift(shape, shift), origin, direction);
    if (distance === null || distance >= nearest) continue;
    nearest = distance;
    best = box;
  }
  return best;
}
