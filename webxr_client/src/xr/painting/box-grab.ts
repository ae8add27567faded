/** A hand that takes hold of a box: at a corner, at a face, or all of it. */
import { Vector3 } from 'three';
import { chooseBox, commitDraft, dragTo, shownIn } from '../../boxes/changes';
import { gripOf, type Grip } from '../../boxes/grip';
import { boxMet } from '../../boxes/met';
import { fromBox, intoBox, moved, stretched, turned, type Shape } from '../../boxes/shape';
import { chosenBox, type ObjectBox, type Triple } from '../../store/boxes';
import { canEdit, state } from '../../store/state';

/** Metres of the scene within which a hand is at a corner or a face's middle. */
const REACH = 0.06;

/** A hand in the recording, local coordinates. */
export interface HandAt {
  readonly tip: Vector3;
  readonly origin: Vector3;
  readonly direction: Vector3;
  /** It points from afar: turning it moves its tip already. */
  readonly far: boolean;
  /** Metres of the scene for one of the recording. */
  readonly scale: number;
}

interface HeldBox {
  readonly box: ObjectBox;
  readonly frame: number;
  readonly start: Shape;
  readonly grip: Grip;
  /** In the box's coordinates when it was taken. */
  readonly from: Triple;
  /** Of the hand about the box's up, radians. */
  readonly heading: number;
}

export class BoxGrab {
  private held: HeldBox | null = null;

  get holds(): boolean {
    return this.held !== null;
  }

  /** Take hold of the chosen box, or choose one that is pointed at; false: neither is there. */
  begin(hand: HandAt): boolean {
    const box = chosenBox.peek();
    const { frame } = state.shown.peek();
    const shape = box && shownIn(box, frame);
    if (box && shape && canEdit.peek()) {
      const from = intoBox(shape, tipOf(hand));
      const grip = gripOf(shape, from, REACH / hand.scale);
      if (grip) {
        this.held = { box, frame, start: shape, grip, from, heading: headingOf(hand, shape) };
        return true;
      }
    }
    const other = boxMet(hand.origin, hand.direction, Infinity);
    if (other) chooseBox(other);
    return other !== null;
  }

  move(hand: HandAt): void {
    if (!this.held) return;
    const { box, frame, start, grip, from, heading } = this.held;
    const to = intoBox(start, tipOf(hand));
    const by: Triple = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
    if (grip !== 'all') {
      dragTo(box, frame, stretched(start, grip, by));
      return;
    }
    const turn = hand.far ? 0 : headingOf(hand, start) - heading;
    dragTo(box, frame, turned(moved(start, by), 2, turn));
  }

  /** Let go: one edit. */
  end(): void {
    if (!this.held) return;
    this.held = null;
    commitDraft();
  }
}

function tipOf({ tip }: HandAt): Triple {
  const [x, y, z] = state.sequence.peek()?.shift ?? [0, 0, 0];
  return [tip.x + x, tip.y + y, tip.z + z];
}

/** Radians about the box's up that a hand points at, from the box's forward. */
function headingOf({ direction }: HandAt, shape: Shape): number {
  const along = direction.dot(fromBox(shape, [1, 0, 0]));
  return Math.atan2(direction.dot(fromBox(shape, [0, 1, 0])), along);
}
