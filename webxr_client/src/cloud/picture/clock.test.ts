import { describe, expect, it } from 'vitest';
import { PlayClock } from './clock';

function clock(speed: number, loop: boolean, start = 0): PlayClock {
  const made = new PlayClock();
  made.begin(start, 30, speed, 90, loop, 1000);
  return made;
}

describe('the play clock', () => {
  it('shows frame n at n thirtieths of a second', () => {
    const playing = clock(1, true);
    expect(playing.frameAt(1000)).toBe(0);
    expect(playing.frameAt(1000 + 1000 * (44.5 / 30))).toBe(44);
  });

  it('loops in both directions', () => {
    expect(clock(1, true).frameAt(1000 + 1000 * (91.5 / 30))).toBe(1);
    const back = clock(-1, true);
    expect(back.direction).toBe(-1);
    expect(back.frameAt(1000)).toBe(0);
    expect(back.frameAt(1000 + 1000 * (1.5 / 30))).toBe(89);
  });

  it('stops at the end without a loop', () => {
    const playing = clock(2, false, 80);
    expect(playing.ended(1000 + 1000 * (9.5 / 60))).toBe(false);
    expect(playing.ended(1000 + 1000 * (10.5 / 60))).toBe(true);
    expect(playing.frameAt(99_000)).toBe(89);
    expect(clock(-1, false, 3).frameAt(99_000)).toBe(0);
  });
});
