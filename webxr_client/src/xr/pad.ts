/** Thumbsticks and touchpads as directions; holding repeats.  Pure, and nothing is allocated. */
import type { PadKind } from './devices';

/** State of the thumb; y up is positive. */
export interface Pad {
  x: number;
  y: number;
  /** Pressed in the middle. */
  click: boolean;
}

const DEAD = 0.3;
const MIDDLE = 0.4;

/**
 * Read a pad into `out`.  A stick points by leaning, a touchpad only while it is pressed: its four
 * quadrants are four buttons round a middle one.  Only the greater axis counts.
 */
export function readPad(kind: PadKind, x: number, y: number, pressed: boolean, out: Pad): void {
  out.x = 0;
  out.y = 0;
  out.click = false;
  if (kind === 'none') return;
  const away = Math.hypot(x, y);
  if (away < MIDDLE) {
    out.click = pressed;
    return;
  }
  if (kind === 'touchpad') {
    if (!pressed) return;
    if (Math.abs(x) > Math.abs(y)) out.x = Math.sign(x);
    else out.y = -Math.sign(y);
    return;
  }
  out.click = pressed && away < 0.7;
  if (out.click) return;
  const lean = (value: number): number =>
    (Math.sign(value) * Math.max(0, Math.abs(value) - DEAD)) / (1 - DEAD);
  if (Math.abs(x) > Math.abs(y)) out.x = lean(x);
  else out.y = lean(-y);
}

/** The buttons that a pad stands in for. */
export interface Chord {
  primary: number;
  secondary: number;
}

/**
 * Take a pad as two buttons, as it is while the grip of a controller without buttons is held: forward
 * the first, to the left the second.  The pad itself says nothing then.
 */
export function takeChord(pad: Pad, out: Chord): void {
  out.primary = Math.max(0, pad.y);
  out.secondary = Math.max(0, -pad.x);
  pad.x = pad.y = 0;
  pad.click = false;
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
