import { afterEach, describe, expect, it, vi } from 'vitest';
import { Listeners } from './listeners';
import { state } from './state';

afterEach(() => {
  vi.restoreAllMocks();
  state.notices.value = [];
});

describe('what runs in every picture', () => {
  it('goes on when one part throws, and tells of it once', () => {
    const log = vi.spyOn(console, 'error').mockImplementation(() => undefined);
    const ran: number[] = [];
    const listeners = new Listeners<number>();
    listeners.add(() => {
      throw new TypeError('no such actuator');
    });
    listeners.add((picture) => ran.push(picture));
    for (let picture = 0; picture < 5; picture++) listeners.run(picture);
    expect(ran).toEqual([0, 1, 2, 3, 4]);
    expect(log).toHaveBeenCalledTimes(1);
    expect(state.notices.value).toHaveLength(1);
    expect(state.notices.value[0]!.detail).toContain('no such actuator');
  });

  it('runs what is left when one stops listening', () => {
    const ran: string[] = [];
    const listeners = new Listeners();
    const stop = listeners.add(() => ran.push('first'));
    const once = listeners.add(() => {
      ran.push('once');
      once();
    });
    listeners.add(() => ran.push('second'));
    listeners.run();
    stop();
    stop();
    listeners.run();
    expect(ran).toEqual(['first', 'once', 'second', 'second']);
  });
});
