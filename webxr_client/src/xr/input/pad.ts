/** Thumbsticks and touchpads as directions; holding repeats.  Pure, and nothing is allocated. */
import type { PadKind } from './devices';

/** State of the thumb; y up is positive. */
export interface Pad {
  x: number;
  y: number;
  /** Pressed in the middle. */
  click: boolean;
  /** The thumb rests on it. */
  touched: boolean;
  /** The thumb rests on the upper (1) or lower (−1) quadrant of a touchpad that is not pressed. */
  over: number;
}

/** State of a pad that nothing touches. */
export function idlePad(): Pad {
  return { x: 0, y: 0, click: false, touched: false, over: 0 };
}

/** Lean of a stick that engages it, and below which it is let go: worn sticks rest at up to 0.4. */
const ENGAGE = 0.5;
const LET_GO = 0.3;
/** Radius of a touchpad's middle button. */
const MIDDLE = 0.4;

type Latch = 'none' | 'x' | 'y' | 'middle';

/**
 * Reads one stick or touchpad.  A stick points by leaning, a touchpad only while it is pressed: its
 * four quadrants are four buttons round a middle one.  The direction or button in which a gesture
 * began is kept until the thumb lets go, so that a thumb that slides does one thing.
 */
export class Thumb {
  private latch: Latch = 'none';
  /** Direction of the touchpad's quadrant. */
  private sign = 0;

  read(kind: PadKind, x: number, y: number, pressed: boolean, touched: boolean, out: Pad): void {
    out.x = 0;
    out.y = 0;
    out.click = false;
    out.touched = touched;
    out.over = 0;
    if (kind === 'none') return;
    if (kind === 'touchpad') this.touchpad(x, y, pressed, out);
    else this.stick(x, y, pressed, out);
  }

  private touchpad(x: number, y: number, pressed: boolean, out: Pad): void {
    if (!pressed) {
      this.latch = 'none';
      const quadrant = Math.hypot(x, y) >= MIDDLE && greater(x, y) === 'y';
      out.touched ||= x !== 0 || y !== 0;
      out.over = quadrant ? -Math.sign(y) : 0;
      return;
    }
    if (this.latch === 'none') {
      this.latch = Math.hypot(x, y) < MIDDLE ? 'middle' : greater(x, y);
      this.sign = Math.sign(this.latch === 'x' ? x : -y);
    }
    if (this.latch === 'middle') out.click = true;
    else out[this.latch] = this.sign;
  }

  private stick(x: number, y: number, pressed: boolean, out: Pad): void {
    const deflection = Math.hypot(x, y);
    if (this.latch === 'middle' ? !pressed : deflection < LET_GO) this.latch = 'none';
    if (this.latch === 'none') {
      if (pressed) this.latch = 'middle';
      else if (deflection >= ENGAGE) this.latch = greater(x, y);
    }
    if (this.latch === 'middle') out.click = true;
    else if (this.latch === 'x') out.x = lean(x);
    else if (this.latch === 'y') out.y = lean(-y);
  }

  /** Release all presses of a source that is out of sight. */
  rest(): void {
    this.latch = 'none';
  }
}

function greater(x: number, y: number): 'x' | 'y' {
  return Math.abs(x) > Math.abs(y) ? 'x' : 'y';
}

/** Part of the way from rest to the rim, with its sign. */
function lean(value: number): number {
  return (Math.sign(value) * Math.max(0, Math.abs(value) - LET_GO)) / (1 - LET_GO);
}

/** Pad actions while the grip is held. */
export interface Chord {
  /** The buttons that the pad stands in for, 0..1. */
  primary: number;
  secondary: number;
  /** Lean for the brush's size; larger is positive. */
  size: number;
}

/**
 * Take a pad as buttons, as it is while the grip is held: forward the first, to the left the second;
 * to the right the brush grows, and back it shrinks.  The pad itself says nothing then.
 */
export function takeChord(pad: Pad, out: Chord): void {
  out.primary = Math.max(0, pad.y);
  out.secondary = Math.max(0, -pad.x);
  out.size = Math.min(0, pad.y) + Math.max(0, pad.x);
  pad.x = pad.y = pad.over = 0;
  pad.click = pad.touched = false;
}

const PRESS = 0.35;
const RELEASE = 0.2;
const FIRST_MS = 350;
const SLOW_MS = 140;
const FAST_MS = 34;
/** Repeats until it runs at full speed. */
const RAMP = 14;
/** Pictures that a direction is held before it repeats: a flick stays one step on a slow display. */
const MIN_HELD = 4;

/** Steps from a held direction: one at once, then running, faster while it is held. */
export class Repeat {
  private direction = 0;
  private next = 0;
  private count = 0;
  private held = 0;

  /** −1, 0 or 1 at this moment. */
  update(value: number, now: number): number {
    const limit = this.direction === 0 ? PRESS : RELEASE;
    const direction = Math.abs(value) >= limit ? Math.sign(value) : 0;
    if (direction !== this.direction) {
      this.direction = direction;
      this.count = 0;
      this.held = 0;
      this.next = now + FIRST_MS;
      return direction;
    }
    this.held += 1;
    if (direction === 0 || now < this.next || this.held < MIN_HELD) return 0;
    const eager = Math.min(1, this.count / RAMP);
    this.count += 1;
    this.next = now + SLOW_MS + (FAST_MS - SLOW_MS) * eager;
    return direction;
  }
}

/** A button or a lean as a switch: says once that it went down, once that it came up. */
export class Switch {
  down = false;

  constructor(
    private readonly press = 0.6,
    private readonly release = 0.4,
  ) {}

  /** 1 when it goes down now, −1 when it comes up now, else 0. */
  update(value: number): -1 | 0 | 1 {
    const down = value >= (this.down ? this.release : this.press);
    if (down === this.down) return 0;
    this.down = down;
    return down ? 1 : -1;
  }
}
