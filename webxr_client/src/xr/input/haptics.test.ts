import { describe, expect, it, vi } from 'vitest';
import { ChangeCounter, pulse, strengthOf } from './haptics';

const id = 'a';

describe('what painting feels like', () => {
  it('is stronger the more points change, and nothing when none does', () => {
    const felt = [0, 1, 10, 100, 1000, 100000].map(strengthOf);
    expect(felt[0]).toBe(0);
    expect(felt[1]).toBeGreaterThan(0);
    for (let i = 2; i < 5; i++) expect(felt[i]).toBeGreaterThan(felt[i - 1]!);
    expect(felt[5]).toBe(1);
  });

  it('counts each point once, and the last answer only for what is still new', () => {
    const counter = new ChangeCounter();
    const answers = [10, 10, 25].map((changed) => counter.take({ id, changed, final: false }));
    expect(answers).toEqual([10, 0, 15]);
    expect(counter.take({ id, changed: 26, final: true })).toBe(1);
  });

  it('feels a lasso, which is counted only when it is done', () => {
    expect(new ChangeCounter().take({ id, changed: 400, final: true })).toBe(400);
  });
});

const resolves = (): Promise<boolean> => Promise.resolve(true);

describe('a pulse on the gamepads that browsers give', () => {
  it('is the first actuator’s in Quest Browser', () => {
    const actuator = { pulse: vi.fn(resolves) };
    pulse({ hapticActuators: [actuator] }, 1.4, 25);
    expect(actuator.pulse).toHaveBeenCalledWith(1, 25);
    expect(actuator.pulse.mock.contexts[0]).toBe(actuator);
  });

  it('is an effect in Chromium, which has no list of actuators', () => {
    const actuator = { effects: ['dual-rumble'], playEffect: vi.fn(resolves) };
    pulse({ vibrationActuator: actuator }, 0.5, 25);
    const [effect, parameters] = actuator.playEffect.mock.calls[0] as unknown as [string, object];
    expect(effect).toBe('dual-rumble');
    expect(parameters).toMatchObject({ duration: 25, strongMagnitude: 0.5, weakMagnitude: 0.5 });
  });

  it('is the effect that there is, where the usual one is missing', () => {
    const actuator = { effects: ['trigger-rumble'], playEffect: vi.fn(resolves) };
    pulse({ vibrationActuator: actuator }, 0.5, 25);
    expect(actuator.playEffect).toHaveBeenCalledWith('trigger-rumble', expect.anything());
  });

  it('falls back to the effect where the list is empty, as in Firefox without a driver', () => {
    const actuator = { playEffect: vi.fn(resolves) };
    pulse({ hapticActuators: [], vibrationActuator: actuator }, 0.5, 25);
    expect(actuator.playEffect).toHaveBeenCalledOnce();
  });

  it.each([
    ['Safari', { vibrationActuator: null }],
    ['a gamepad that knows no haptics', {}],
    ['an empty list', { hapticActuators: [] }],
    ['a list with a hole', { hapticActuators: [null] }],
    ['no effects', { vibrationActuator: { effects: [], playEffect: resolves } }],
    ['a hand without a gamepad', null],
    ['an input without one', undefined],
  ])('is nothing for %s', (_, gamepad) => {
    expect(pulse(gamepad, 1, 25)).toBe(false);
  });

  it('is told to be none once an actuator has refused, until it gives one again', async () => {
    const refused = new DOMException('not visible', 'InvalidStateError');
    const act = vi.fn(() => Promise.reject<boolean>(refused));
    const gamepad = { hapticActuators: [{ pulse: act }] };
    expect(pulse(gamepad, 1, 25)).toBe(true);
    await new Promise((resolve) => setTimeout(resolve));
    act.mockImplementation(resolves);
    expect(pulse(gamepad, 1, 25)).toBe(false);
    await new Promise((resolve) => setTimeout(resolve));
    expect(pulse(gamepad, 1, 25)).toBe(true);
  });

  it('costs nothing where the actuator throws or refuses', async () => {
    const refuses = (): Promise<never> => Promise.reject(new DOMException('gone', 'InvalidState'));
    const throws = (): never => {
      throw new TypeError('not allowed');
    };
    for (const act of [refuses, throws]) {
      pulse({ hapticActuators: [{ pulse: act }] }, 1, 25);
      pulse({ vibrationActuator: { playEffect: act } }, 1, 25);
    }
    const hostile = Object.defineProperty({}, 'hapticActuators', { get: throws });
    expect(() => pulse(hostile, 1, 25)).not.toThrow();
    // An unhandled rejection would fail this run.
    await new Promise((resolve) => setTimeout(resolve));
  });
});
