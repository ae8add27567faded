/** Actions of sticks, pads and buttons besides painting. */
import { showNatural } from '../../example/store';
import { actions } from '../../store/actions';
import { peek } from '../../store/watch';
import { state } from '../../store/state';
import type { Lessons } from './lessons';
import type { Pointer } from './pointer';

/** The brush grows by this factor a second at full lean. */
const GROWTH = 4;
/** Steps of a touchpad's quadrant. */
const NOTCHES = 1;

export class Buttons {
  constructor(
    private readonly lessons: Lessons,
    private readonly togglePanel: () => void,
  ) {}

  update(brush: Pointer | null, other: Pointer | null, seconds: Float64Array, now: number): void {
    if (brush) this.ofBrush(brush, seconds, now);
    if (other) this.ofOther(other);
  }

  private ofBrush(brush: Pointer, seconds: Float64Array, now: number): void {
    if (brush.edge.squeeze !== 0) showNatural(brush.edge.squeeze > 0);
    this.time(brush, now);
    this.size(brush, seconds, now);
    if (brush.edge.primary === 1) {
      actions.tools.toggleEraser();
      this.lessons.markDone('erase', brush.device);
    }
    if (brush.edge.secondary === 1) {
      actions.history.undo();
      this.lessons.markDone('undo', brush.device);
    }
  }

  private ofOther(other: Pointer): void {
    if (other.edge.primary === 1) {
      this.togglePanel();
      this.lessons.markDone('panel', other.device);
    }
    if (other.edge.press === 1) {
      actions.time.nextDoubtful(1);
      this.lessons.markDone('doubt', other.device);
    }
    if (other.edge.secondary === 1) {
      actions.history.redo();
      this.lessons.markDone('redo', other.device);
    }
    if (other.pad.x !== 0) this.lessons.markDone('turn', other.device);
    if (other.pad.y > 0) this.lessons.markDone('teleport', other.device);
  }

  /** Left and right are frames; held, they run; the middle plays. */
  private time(hand: Pointer, now: number): void {
    const step = hand.repeatX.update(hand.pad.x, now);
    if (step !== 0) {
      actions.time.step(step);
      this.lessons.markDone('step', hand.device);
    }
    if (hand.edge.press === 1) {
      actions.time.togglePlay();
      this.lessons.markDone('play', hand.device);
    }
  }

  /** The brush's size, by the pad while the grip is held. */
  private size(hand: Pointer, seconds: Float64Array, now: number): void {
    const lean = hand.sizes;
    if (hand.device.pad === 'touchpad') {
      const notch = hand.repeatSize.update(lean, now);
      if (notch === 0) return;
      actions.tools.nudgeRadius(notch * NOTCHES);
      this.lessons.markDone('size', hand.device);
    } else if (lean !== 0) {
      actions.tools.setRadius(peek(state.brush).radius * GROWTH ** (lean * seconds[0]!));
      this.lessons.markDone('size', hand.device);
    }
  }
}
