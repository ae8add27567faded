/** Actions of sticks, pads and buttons besides painting. */
import { Vector3 } from 'three';
import { actions } from '../actions';
import { peek } from '../watch';
import type { Label } from '../protocol/messages';
import { state } from '../state';
import { LEVEL_TICK, type Pulse } from './haptics';
import type { Lessons } from './lessons';
import type { Pointer } from './pointer';
import type { Rig } from './rig';
import { xrSettings } from './settings';

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
    const { y } = hand.pad;
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

/** One looks at the palette when its middle is within this angle of straight ahead: 20°. */
const LOOKING = Math.cos((20 * Math.PI) / 180);

/**
 * The part of a pad's lean that is for labels, and the rest of it is for walking: all of it while one
 * looks at the palette, else only down, which no teleport needs.
 */
export function labelLean(y: number, looking: boolean, glides: boolean): number {
  return looking || (y < 0 && !glides) ? y : 0;
}

/** The label so many steps below the active one in the palette, round and round. */
export function labelBeside(palette: readonly Label[], active: number, steps: number): number {
  const at = palette.findIndex(({ id }) => id === active);
  const from = at < 0 && steps < 0 ? 0 : at;
  return palette[(from + steps + palette.length) % palette.length]?.id ?? active;
}

/** The palette hand's pad walks through the labels. */
export class LabelSwitch {
  private readonly ahead = new Vector3();
  private readonly way = new Vector3();

  /** Once per picture, before the pad walks; true when another label was chosen. */
  update(hand: Pointer, rig: Rig, palette: Vector3 | null, now: number): boolean {
    const glides = peek(xrSettings).move === 'smooth' && hand.device.pad === 'stick';
    const looking = palette !== null && this.looksAt(rig, palette);
    const lean = labelLean(hand.pad.y, looking, glides);
    const step = -hand.repeatY.update(lean, now);
    if (lean !== 0) hand.pad.y = 0;
    if (step === 0) return false;
    const active = peek(state.activeLabel);
    const next = labelBeside(peek(state.palette), active, step);
    if (next === active) return false;
    actions.selectLabel(next);
    hand.pulse(LEVEL_TICK.strength, LEVEL_TICK.milliseconds);
    return true;
  }

  private looksAt(rig: Rig, place: Vector3): boolean {
    this.ahead.set(0, 0, -1).applyQuaternion(rig.turned);
    this.way.copy(place).sub(rig.head).normalize();
    return this.ahead.dot(this.way) > LOOKING;
  }
}
