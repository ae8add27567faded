import { describe, expect, it } from 'vitest';
import { idlePad, Repeat, Switch, takeChord, Thumb } from './pad';
import { Pressure } from './pressure';

const out = idlePad();
const pad = (kind: 'stick' | 'touchpad', x: number, y: number, pressed = false) => {
  new Thumb().read(kind, x, y, pressed, false, out);
  return [Math.sign(out.x), Math.sign(out.y) || 0, out.click];
};

describe('a thumbstick', () => {
  it('points where it leans most; up is positive', () => {
    expect(pad('stick', 0.9, 0.2)).toEqual([1, 0, false]);
    expect(pad('stick', -0.5, 0.2)).toEqual([-1, 0, false]);
    expect(pad('stick', 0.1, -0.8)).toEqual([0, 1, false]);
  });

  it('is pressed, and silent at rest', () => {
    expect(pad('stick', 0.05, 0.02, true)).toEqual([0, 0, true]);
    expect(pad('stick', 0.1, 0.1)).toEqual([0, 0, false]);
  });
});

describe('a touchpad', () => {
  it('has four quadrants round a middle, and only pressing counts', () => {
    expect(pad('touchpad', 0.8, 0.1)).toEqual([0, 0, false]);
    expect(pad('touchpad', 0.8, 0.1, true)).toEqual([1, 0, false]);
    expect(pad('touchpad', -0.8, 0.1, true)).toEqual([-1, 0, false]);
    expect(pad('touchpad', 0.1, -0.8, true)).toEqual([0, 1, false]);
    expect(pad('touchpad', 0.1, 0.8, true)).toEqual([0, -1, false]);
    expect(pad('touchpad', 0.1, 0.1, true)).toEqual([0, 0, true]);
  });

  it('says that the thumb rests on its upper or lower quadrant', () => {
    const over = (x: number, y: number, pressed = false): number => {
      pad('touchpad', x, y, pressed);
      return out.over;
    };
    expect([over(0, -0.8), over(0.1, 0.8), over(0.8, 0.1), over(0, 0.1)]).toEqual([1, -1, 0, 0]);
    expect(over(0, -0.8, true)).toBe(0);
  });
});

describe('a thumb', () => {
  /** Answers of a pad while a thumb goes from place to place: its direction or its click. */
  const slide = (kind: 'stick' | 'touchpad', ...places: readonly [number, number, boolean][]) => {
    const thumb = new Thumb();
    return places.map(([x, y, pressed]) => {
      thumb.read(kind, x, y, pressed, false, out);
      return out.click ? 'middle' : [Math.sign(out.x), Math.sign(out.y) || 0].join();
    });
  };

  it('that slides over a pressed touchpad does one thing', () => {
    const down = slide('touchpad', [0, 0.8, true], [0.7, 0.5, true], [0.9, 0, true], [0, 0, true]);
    expect(new Set(down)).toEqual(new Set(['0,-1']));
    expect(slide('touchpad', [0.1, 0, true], [0.9, 0, true])).toEqual(['middle', 'middle']);
  });

  it('does the next thing once it was lifted', () => {
    const twice = slide('touchpad', [0, 0.8, true], [0.9, 0, false], [0.9, 0, true]);
    expect(twice).toEqual(['0,-1', '0,0', '1,0']);
  });

  it('that rolls a stick along its rim does one thing until it is back in the middle', () => {
    const rolled = slide('stick', [0.9, 0, false], [0.7, 0.7, false], [0.1, 0.9, false]);
    expect(rolled).toEqual(['1,0', '1,0', '0,0']);
    expect(slide('stick', [0.9, 0, false], [0, 0, false], [0, 0.9, false]).at(-1)).toBe('0,-1');
  });

  it('that leans a stick while it presses it only presses', () => {
    expect(slide('stick', [0, 0, true], [0.9, 0, true])).toEqual(['middle', 'middle']);
  });

  it('at rest on a worn stick, or only touching a touchpad, does nothing', () => {
    for (const [x, y] of [[0.4, 0.2], [-0.35, 0.35], [0, -0.45]] as const) {
      expect(slide('stick', [x, y, false])).toEqual(['0,0']);
      expect(slide('touchpad', [x, y, false])).toEqual(['0,0']);
    }
  }); // prettier-ignore
});

describe('a pad while the grip is held', () => {
  it.each(['stick', 'touchpad'] as const)('is two buttons and the size: %s', (kind) => {
    const chord = (x: number, y: number): number[] => {
      const buttons = { primary: 0, secondary: 0, size: 0 };
      new Thumb().read(kind, x, y, kind === 'touchpad', true, out);
      takeChord(out, buttons);
      expect(out).toEqual(idlePad());
      return [buttons.primary, buttons.secondary, buttons.size];
    };
    expect(chord(0, -1)).toEqual([1, 0, 0]);
    expect(chord(-1, 0)).toEqual([0, 1, 0]);
    expect(chord(0, 1)).toEqual([0, 0, -1]);
    expect(chord(1, 0)).toEqual([0, 0, 1]);
    expect(chord(0, 0)).toEqual([0, 0, 0]);
  });
});

describe('holding', () => {
  it('steps once at once, then runs faster and faster', () => {
    const repeat = new Repeat();
    const steps: number[] = [];
    for (let now = 0; now < 3000; now += 10) if (repeat.update(1, now) === 1) steps.push(now);
    expect(steps[0]).toBe(0);
    expect(steps[1]).toBeGreaterThanOrEqual(350);
    const first = steps[2]! - steps[1]!;
    const last = steps.at(-1)! - steps.at(-2)!;
    expect(last).toBeLessThan(first / 2);
  });

  it('stays one step on a display of three pictures a second', () => {
    const repeat = new Repeat();
    const steps = [
      repeat.update(1, 0),
      repeat.update(1, 330),
      repeat.update(1, 660),
      repeat.update(0, 990),
    ];
    expect(steps).toEqual([1, 0, 0, 0]);
  });

  it('begins anew in the other direction', () => {
    const repeat = new Repeat();
    expect(repeat.update(-0.9, 0)).toBe(-1);
    expect(repeat.update(0.9, 10)).toBe(1);
  });
});

describe('a switch', () => {
  it('does not flutter round its limit', () => {
    const button = new Switch(0.6, 0.4);
    expect([0.5, 0.65, 0.55, 0.62, 0.45, 0.39, 0.5].map((value) => button.update(value))).toEqual([
      0, 1, 0, 0, 0, -1, 0,
    ]);
  });
});

describe('the trigger as pressure', () => {
  const run = (samples: [number, number][]): number[] => {
    const pressure = new Pressure();
    return samples.map(([value, now]) => pressure.update(value, now));
  };

  it('paints with all of the sphere after a quick full press, never with half first', () => {
    expect(
      run([
        [0, 0],
        [0.3, 10],
        [0.6, 20],
        [0.95, 30],
        [0.5, 40],
        [0.05, 50],
      ]),
    ).toEqual([0, 0, 0, 1, 1, 0]);
  });

  it('paints with half of it while it is held half pressed', () => {
    expect(
      run([
        [0.4, 0],
        [0.4, 40],
        [0.4, 80],
        [0.9, 90],
        [0, 100],
      ]),
    ).toEqual([0, 0, 0.5, 1, 0]);
  });

  it('goes back to half only when it stays there', () => {
    expect(
      run([
        [1, 0],
        [0.4, 10],
        [0.4, 100],
        [0.4, 220],
      ]),
    ).toEqual([1, 1, 1, 0.5]);
  });

  it('makes a short tap a dab', () => {
    expect(
      run([
        [0.4, 0],
        [0.4, 20],
        [0, 40],
        [0, 60],
      ]),
    ).toEqual([0, 0, 0.5, 0]);
  });
});
