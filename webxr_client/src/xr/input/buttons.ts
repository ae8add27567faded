/** Actions of sticks, pads and buttons besides painting. */
import { actions } from '../../store/actions';
import { peek } from '../../store/watch';
import type { Label } from '../../protocol/messages';
import { state } from '../../store/state';
import { LEVEL_TICK, type Pulse } from './haptics';
import type { Lessons, Part } from './lessons';
import type { Pointer } from './pointer';

/** The brush grows by this factor a second at full lean. */
const GROWTH = 4;
/** Steps of a touchpad's quadrant. */
const NOTCHES = 1;

export class Buttons {
  constructor(
    private readonly lessons: Lessons,
    private readonly togglePanel: () => void,
    private readonly pulse: (pulse: Pulse) => void,
  ) {}

  /** After the labels had their part of the other hand's pad. */
  update(brush: Pointer | null, other: Pointer | null, seconds: Float64Array, now: number): void {
    if (brush) this.ofBrush(brush, seconds, now);
    if (other) this.ofOther(other);
  }

  private ofBrush(brush: Pointer, seconds: Float64Array, now: number): void {
    this.time(brush, now);
    this.size(brush, seconds, now);
    if (brush.edge.primary === 1) {
      actions.toggleEraser();
      this.lessons.done('erase');
    }
    if (brush.edge.secondary === 1) {
      actions.undo();
      this.lessons.done('undo');
    }
  }

  private ofOther(other: Pointer): void {
    if (other.edge.primary === 1) {
      this.togglePanel();
      this.lessons.done('panel');
    }
    if (other.edge.press === 1) {
      actions.nextDoubtful(1);
      this.lessons.done('doubt');
    }
    if (other.edge.secondary === 1) {
      actions.redo();
      this.lessons.done('redo');
    }
    if (other.pad.x !== 0) this.lessons.done('turn');
    if (other.pad.y > 0) this.lessons.done('teleport');
  }

  /** Left and right are frames; held, they run; the middle plays. */
  private time(hand: Pointer, now: number): void {
    const step = hand.repeatX.update(hand.pad.x, now);
    if (step !== 0) {
      actions.step(step);
      this.lessons.done('step');
    }
    if (hand.edge.press === 1) {
      if (actions.completeObject()) return;
      actions.togglePlay();
      this.lessons.done('play');
    }
  }

  /** Up and down: the size of the brush, or the level of the object that is shown. */
  private size(hand: Pointer, seconds: Float64Array, now: number): void {
    const y = hand.sizes === 0 ? hand.pad.y : hand.sizes;
    if ((peek(state.object)?.levels ?? 0) > 0) {
      this.level(hand.repeatY.update(y, now));
      return;
    }
    if (hand.device.pad === 'touchpad') {
      const notch = hand.repeatY.update(y, now);
      if (notch === 0) return;
      actions.nudgeRadius(notch * NOTCHES);
      this.lessons.done('size');
    } else if (y !== 0) {
      actions.setRadius(peek(state.brush).radius * GROWTH ** (y * seconds[0]!));
      this.lessons.done('size');
    }
  }

  private level(step: number): void {
    if (step === 0) return;
    const before = peek(state.object)?.level;
    actions.stepObject(step);
    if (peek(state.object)?.level !== before) this.pulse(LEVEL_TICK);
  }
}

/**
 * The part of a controller's pad that switches labels: its chord or second touchpad, all of up and down
 * while its ray is on the palette, a touchpad's quadrants where nothing else needs them.  Where one
 * looks changes nothing, and neither does a stick that goes somewhere.
 */
export function labelLean(
  { device, labels, pad }: Pick<Pointer, 'device' | 'labels' | 'pad'>,
  part: Part,
  onPalette: boolean,
): number {
  if (labels !== 0) return labels;
  if (onPalette) return pad.y;
  if (device.pad !== 'touchpad') return 0;
  if (part === 'alone') return pad.y;
  return part === 'other' ? Math.min(0, pad.y) : 0;
}

/** The label so many steps below the active one in the palette, round and round. */
export function labelBeside(palette: readonly Label[], active: number, steps: number): number {
  const at = palette.findIndex(({ id }) => id === active);
  const from = at < 0 && steps < 0 ? 0 : at;
  return palette[(from + steps + palette.length) % palette.length]?.id ?? active;
}

/** Switches labels by the pad of a hand, before the pad does anything else. */
export class LabelSwitch {
  /** Once per picture and hand; true when another label was chosen. */
  update(hand: Pointer, part: Part, onPalette: boolean, now: number): boolean {
    // Up and down of the hand that paints go through an object's levels while one is shown.
    const levels = part !== 'other' && (peek(state.object)?.levels ?? 0) > 0;
    const lean = levels && !onPalette && hand.labels === 0 ? 0 : labelLean(hand, part, onPalette);
    const step = -hand.repeatLabel.update(lean, now);
    if (lean !== 0) hand.pad.y = 0;
    if (step === 0) return false;
    const active = peek(state.activeLabel);
    const next = labelBeside(peek(state.palette), active, step);
    if (next === active) return false;
    actions.selectLabel(next);
    if (part === 'other') hand.pulse(LEVEL_TICK.strength, LEVEL_TICK.milliseconds);
    return true;
  }
}
