/**
 * Pulses on what a controller has for them.  Quest Browser and Firefox have `hapticActuators`, whose
 * entries pulse; Chromium has `vibrationActuator`, which plays effects; some have neither.
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

/** Let a gamepad pulse, strength 0..1; without an actuator, or with one that fails, nothing happens. */
export function pulse(gamepad: unknown, strength: number, milliseconds: number): void {
  try {
    const answer = start(gamepad as Vibrating | null | undefined, strength, milliseconds);
    if (answer instanceof Promise) answer.catch(ignore);
  } catch {
    // An actuator that cannot pulse (any more) has nothing to tell.
  }
}

function start(gamepad: Vibrating | null | undefined, strength: number, duration: number): unknown {
  const actuator = gamepad?.hapticActuators?.[0] ?? gamepad?.vibrationActuator;
  const power = Math.min(1, Math.max(0, strength));
  if (actuator?.pulse) return actuator.pulse(power, duration);
  if (!actuator?.playEffect) return undefined;
  const effect = actuator.effects?.includes(RUMBLE) === false ? actuator.effects[0] : RUMBLE;
  if (effect === undefined) return undefined;
  const triggers = { leftTrigger: power, rightTrigger: power };
  const parameters = { startDelay: 0, duration, strongMagnitude: power, weakMagnitude: power };
  return actuator.playEffect(effect, { ...parameters, ...triggers });
}

function ignore(): void {
  return;
}
