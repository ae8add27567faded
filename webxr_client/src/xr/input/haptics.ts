/** Haptics of the hand: points that change, frames passing, work that ends, a lock; and the actuators that give them. */
import { follow, peek } from '../../store/watch';
import type { StrokeResult } from '../../protocol/messages';
import { isActive, state } from '../../store/state';

/** Strength of a pulse for so many newly changed points: felt from one, full at a thousand. */
export function strengthOf(points: number): number {
  return points <= 0 ? 0 : Math.min(1, 0.2 + 0.8 * (Math.log10(points) / 3));
}

export interface Pulse {
  readonly strength: number;
  readonly milliseconds: number;
}

/** A short dry tick, unlike the hum of painting. */
const FRAME_TICK: Pulse = { strength: 0.35, milliseconds: 6 };
export const BUTTON_TICK: Pulse = { strength: 0.2, milliseconds: 8 };
/** Another level of an object is shown. */
export const LEVEL_TICK: Pulse = { strength: 0.5, milliseconds: 15 };
/** Tracking ended, or a label is locked. */
export const BUMP: Pulse = { strength: 1, milliseconds: 120 };
export const PAINT_MS = 25;

/**
 * Differences of the server's running counts, stroke by stroke.  Points that already have the label
 * cause no pulse.
 */
export class ChangeCounter {
  private readonly seen = new Map<string, number>();

  /** Number of changed points in this answer beyond the earlier ones. */
  take(result: Pick<StrokeResult, 'id' | 'changed' | 'final'>): number {
    const before = this.seen.get(result.id) ?? 0;
    if (result.final) this.seen.delete(result.id);
    else this.seen.set(result.id, result.changed);
    return Math.max(0, result.changed - before);
  }
}

/** Haptics of the brush hand besides painting: a frame passed, a run ended, a label was locked. */
export class EventHaptics {
  private frame = -1;
  private readonly unsubscribers: (() => void)[];

  constructor(private readonly sendPulse: (pulse: Pulse) => void) {
    this.unsubscribers = [this.followJobs(), this.followLocks()];
  }

  /** Once per picture. */
  update(): void {
    const frame = peek(state.frame);
    if (frame === this.frame) return;
    // While it plays the hand would only buzz.
    if (this.frame >= 0 && !peek(state.playing)) this.sendPulse(FRAME_TICK);
    this.frame = frame;
  }

  private followJobs(): () => void {
    let running = new Set<string>();
    return follow(() => {
      const tracking = state.jobs.value.filter((job) => job.kind === 'tracking');
      const active = new Set(tracking.filter(isActive).map((job) => job.id));
      const ended = [...running].some((id) => !active.has(id));
      running = active;
      if (ended) this.sendPulse(BUMP);
    });
  }

  private followLocks(): () => void {
    let before: ReadonlySet<number> | null = null;
    return follow(() => {
      const palette = state.palette.value;
      const locked = new Set(palette.filter((label) => label.locked).map((label) => label.id));
      const more = before !== null && [...locked].some((id) => !before!.has(id));
      before = locked;
      if (more) this.sendPulse(BUMP);
    });
  }

  dispose(): void {
    for (const stop of this.unsubscribers) stop();
  }
}

/**
 * Pulses on a controller's actuators.  Quest Browser and Firefox have `hapticActuators` with a method
 * to pulse; Chromium has `vibrationActuator`, which plays effects; some browsers have neither.
 */
interface Actuator {
  readonly effects?: readonly string[];
  pulse?: (strength: number, milliseconds: number) => unknown;
  playEffect?: (effect: string, parameters: object) => unknown;
}

interface Vibrating {
  readonly hapticActuators?: ArrayLike<Actuator | null | undefined> | null;
  readonly vibrationActuator?: Actuator | null;
}

/** The effect that every vibrating gamepad of the specification knows. */
const RUMBLE = 'dual-rumble';

/** Gamepads with a refused last pulse; later pulses may succeed, for example in a visible page. */
const refusing = new WeakSet<object>();

/** Let a gamepad pulse, strength 0..1; false where nothing can be felt, so far as is known. */
export function pulse(gamepad: unknown, strength: number, milliseconds: number): boolean {
  if (typeof gamepad !== 'object' || gamepad === null) return false;
  try {
    const answer = start(gamepad, strength, milliseconds);
    if (answer instanceof Promise) {
      answer.then(
        () => refusing.delete(gamepad),
        () => refusing.add(gamepad),
      );
    }
    return answer !== undefined && !refusing.has(gamepad);
  } catch {
    return false;
  }
}

/** The property by which a gamepad pulses. */
export function pulsesBy(gamepad: unknown): 'hapticActuators' | 'vibrationActuator' | 'none' {
  const vibrating = (gamepad ?? {}) as Vibrating;
  if (vibrating.hapticActuators?.[0]) return 'hapticActuators';
  return vibrating.vibrationActuator ? 'vibrationActuator' : 'none';
}

function start(gamepad: Vibrating, strength: number, duration: number): unknown {
  const actuator = gamepad.hapticActuators?.[0] ?? gamepad.vibrationActuator;
  const power = Math.min(1, Math.max(0, strength));
  if (actuator?.pulse) return actuator.pulse(power, duration) ?? true;
  if (!actuator?.playEffect) return undefined;
  const effect = actuator.effects?.includes(RUMBLE) === false ? actuator.effects[0] : RUMBLE;
  if (effect === undefined) return undefined;
  const triggers = { leftTrigger: power, rightTrigger: power };
  const parameters = { startDelay: 0, duration, strongMagnitude: power, weakMagnitude: power };
  return actuator.playEffect(effect, { ...parameters, ...triggers }) ?? true;
}
