import { describe, expect, it } from 'vitest';
import { xrSettings, change as set } from '../../store/xr-settings';
import { registered } from '../testing/registry';
import { TestSource, TestInputs } from '../testing/sources';

const GRIPLESS = 'generic-trigger-touchpad';
const controller = (side: XRHandedness, profile?: string): TestSource =>
  new TestSource(profile === undefined ? { side } : { side, profile });
const pinch = (side: XRHandedness): TestSource =>
  new TestSource({ mode: 'transient-pointer', side });

describe('taking hold of the room', () => {
  it('is the grip, on either hand, also while the trigger paints', () => {
    const [left, right] = [controller('left'), controller('right')];
    const inputs = new TestInputs(left, right);
    inputs.advance();
    right.squeeze = 1;
    left.trigger = 1;
    inputs.advance();
    const { brush, other } = inputs.pointers;
    expect(inputs.pointers.holds(brush, true, false)).toBe(true);
    expect(inputs.pointers.holds(other, false, false)).toBe(false);
  });

  it('is the press of the one that does not paint where there is no grip; the other joins in', () => {
    const [left, right] = [controller('left', GRIPLESS), controller('right', GRIPLESS)];
    const inputs = new TestInputs(left, right);
    inputs.advance();
    left.trigger = right.trigger = 1;
    inputs.advance();
    const { brush, other } = inputs.pointers;
    expect(inputs.pointers.holds(brush, false, false)).toBe(false);
    expect(inputs.pointers.holds(brush, false, true)).toBe(true);
    expect(inputs.pointers.holds(other, false, false)).toBe(true);
    // Both triggers make a box, and a panel is pressed with the same one.
    expect(inputs.pointers.holds(other, true, false)).toBe(false);
    inputs.pointers.bodyOf(other!).on = { leave: () => undefined } as never;
    expect(inputs.pointers.holds(other, false, false)).toBe(false);
  });
});

describe('who comes and goes', () => {
  it('a hand beside a controller takes nothing from it, and stays when that goes', () => {
    const [right, bare] = [controller('right'), new TestSource({ hand: true })];
    const inputs = new TestInputs(right);
    inputs.change([bare]);
    expect(inputs.pointers.brush?.source).toBe(right.xr);
    inputs.change([], [bare]);
    expect(inputs.pointers.brush?.source).toBe(right.xr);
    inputs.change([bare], [right]);
    expect(inputs.pointers.brush?.source).toBe(bare.xr);
    inputs.advance(2);
    expect(inputs.messages).toEqual([]);
    inputs.change([], [bare]);
    expect(inputs.pointers.brush).toBeNull();
  });

  it('a controller that stays away is missed after a second, one that a menu took is not', () => {
    const right = controller('right');
    const inputs = new TestInputs(right);
    inputs.show('visible-blurred');
    inputs.change([], [right]);
    inputs.advance(5);
    inputs.show('visible');
    inputs.advance(0.5);
    inputs.change([right]);
    inputs.advance(2);
    expect(inputs.messages).toEqual([]);
    inputs.change([], [right]);
    inputs.advance(0.5);
    expect(inputs.messages).toEqual([]);
    inputs.advance(0.6);
    expect(inputs.messages).toEqual([
      'The right controller is disconnected:\npress its system button to switch it on',
    ]);
  });

  it('is told within three seconds that nothing came, with what to do; once, and not where something points', () => {
    const inputs = new TestInputs();
    inputs.show('visible-blurred');
    inputs.advance(5);
    inputs.show('visible');
    inputs.advance(1.5);
    expect(inputs.messages).toEqual([]);
    inputs.advance(1.4);
    expect(inputs.messages).toEqual([
      'Look at a point and pinch,\nhold a hand in front of the headset,\nor press a system button of a controller',
    ]);
    inputs.advance(5);
    expect(inputs.messages).toHaveLength(1);
    const [eyes, look] = [new TestInputs(), pinch('right')];
    eyes.change([look]);
    eyes.advance();
    eyes.change([], [look]);
    eyes.advance(5);
    expect(eyes.messages).toEqual([]);
  });

  it('is told to touch the screen where the session is on one', () => {
    const inputs = new TestInputs();
    inputs.session.interactionMode = 'screen-space';
    inputs.advance(3);
    expect(inputs.messages).toEqual(['Touch the screen\nwhere you want to paint']);
  });

  it('is noticed within a second where no event tells of it', () => {
    const [left, right] = [controller('left'), controller('right')];
    const inputs = new TestInputs(left);
    inputs.arrive([right, new TestSource({ mode: 'brain-waves' })]);
    inputs.advance(1);
    expect(inputs.pointers.brush?.source).toBe(right.xr);
    inputs.arrive([], [right]);
    inputs.advance(1);
    inputs.advance(1.1);
    expect(inputs.pointers.brush?.source).toBe(left.xr);
    expect(inputs.messages.filter((text) => text.startsWith('Unknown'))).toHaveLength(1);
  });

  it('the wished hand is asked anew, and a trigger that is held does not paint for it', () => {
    const [left, right] = [controller('left'), controller('right')];
    const inputs = new TestInputs(left, right);
    inputs.advance();
    left.trigger = 1;
    inputs.advance();
    set({ hand: 'left' });
    inputs.pointers.assign();
    inputs.advance();
    expect(inputs.pointers.brush?.source).toBe(left.xr);
    expect(inputs.pointers.palette?.source).toBe(right.xr);
    expect(inputs.pointers.brush?.trigger).toBe(0);
    set({ hand: 'right' });
    expect(xrSettings.peek().hand).toBe('right');
  });

  it('a press that is told before its source is heard', () => {
    const inputs = new TestInputs();
    const look = pinch('right');
    inputs.select(look, true);
    inputs.change([look]);
    inputs.advance();
    expect(inputs.pointers.bodies).toHaveLength(1);
    expect(inputs.pointers.brush?.edge.click).toBe(1);
  });

  it('a pinch that comes and goes between two pictures is pressed in one and let go in the next', () => {
    const inputs = new TestInputs();
    const look = pinch('right');
    inputs.change([look]);
    inputs.select(look, true);
    inputs.advance();
    expect(inputs.pointers.brush?.trigger).toBe(1);
    inputs.select(look, false);
    inputs.change([], [look]);
    look.tracked = false;
    inputs.advance();
    expect(inputs.pointers.brush?.edge.click).toBe(-1);
    inputs.advance();
    expect(inputs.pointers.brush).toBeNull();
  });

  it('what is only tracked does not press, and does once it is held', () => {
    const inputs = new TestInputs(new TestSource({ hand: true }));
    const right = controller('right');
    inputs.change([right], [], 'trackedsourceschange');
    expect(inputs.pointers.brush?.kind.name).toBe('hand');
    inputs.change([right]);
    inputs.change([], [right], 'trackedsourceschange');
    expect(inputs.pointers.brush?.source).toBe(right.xr);
    expect(inputs.pointers.bodies).toHaveLength(2);
  });

  it('an input of a kind that is not known says so', () => {
    const inputs = new TestInputs(new TestSource({ mode: 'brain-waves', profile: 'acme-cap' }));
    expect(inputs.pointers.bodies).toHaveLength(0);
    expect(inputs.messages).toEqual(['Unknown kind of input:\nbrain-waves (acme-cap)']);
  });

  it('a controller is missed once that the headset has not seen for a second', () => {
    const right = controller('right');
    const inputs = new TestInputs(right);
    inputs.advance();
    right.tracked = false;
    right.trigger = 1;
    inputs.advance(0.4);
    expect([inputs.pointers.brush?.tracked, inputs.pointers.brush?.trigger]).toEqual([false, 0]);
    for (let i = 0; i < 5; i++) inputs.advance(0.4);
    expect(inputs.messages).toEqual([
      'The headset does not see the right controller:\nhold it in front of the headset',
    ]);
  });
});

it('a press is heard of a pad that tells of it by events alone, a pulled trigger by its value', () => {
  for (const [id, heard] of [['generic-touchpad', 1], ['htc-vive', 0]] as const) {
    const source = registered(id, 'right');
    const inputs = new TestInputs(source);
    inputs.advance();
    inputs.select(source, true);
    inputs.advance();
    expect(inputs.pointers.brush!.trigger, id).toBe(heard);
  }
}); // prettier-ignore

describe('handedness', () => {
  const hands = (): { inputs: TestInputs; left: TestSource; right: TestSource } => {
    const [left, right] = (['left', 'right'] as const).map(
      (side) => new TestSource({ hand: true, side }),
    ) as [TestSource, TestSource];
    return { inputs: new TestInputs(left, right), left, right };
  };
  const paints = ({ pointers }: TestInputs): string | undefined => pointers.brush?.side;

  it('stays while the wished hand is away for a moment, and the other one paints nothing', () => {
    const { inputs, left, right } = hands();
    inputs.change([], [right]);
    inputs.select(left, true);
    inputs.advance(0.9);
    expect([paints(inputs), inputs.pointers.other?.source, inputs.messages]).toEqual([
      undefined,
      left.xr,
      [],
    ]);
    inputs.change([right]);
    inputs.advance(0.9);
    expect([paints(inputs), inputs.messages]).toEqual(['right', []]);
  });

  it('changes after a second, with a sign, and never in a pinch', () => {
    const { inputs, left, right } = hands();
    inputs.change([], [right]);
    inputs.select(left, true);
    for (let i = 0; i < 3; i++) inputs.advance(0.9);
    expect(paints(inputs)).toBeUndefined();
    inputs.select(left, false);
    inputs.advance();
    inputs.advance();
    expect([paints(inputs), inputs.messages]).toEqual(['left', ['The left hand paints now']]);
    // It finishes its stroke when the other one is back.
    inputs.select(left, true);
    inputs.advance();
    inputs.change([right]);
    inputs.advance(2);
    expect(paints(inputs)).toBe('left');
    inputs.select(left, false);
    inputs.advance();
    inputs.advance();
    expect([paints(inputs), inputs.messages.at(-1)]).toEqual([
      'right',
      'The right hand paints again',
    ]);
  });

  it('is said with the reason where a controller went', () => {
    const [left, right] = [controller('left'), controller('right')];
    const inputs = new TestInputs(left, right);
    inputs.change([], [right]);
    inputs.advance(1.1);
    expect(inputs.messages.at(-1)).toBe(
      'The right controller is disconnected:\npress its system button to switch it on\nThe left controller paints now',
    );
  });
});

describe('a press where the headset guesses', () => {
  it('is told while it is held, of what is held in a hand', () => {
    const right = controller('right');
    const inputs = new TestInputs(right);
    const guessedAfter = (trigger: number, guessed: boolean): boolean => {
      Object.assign(right, { trigger, guessed });
      inputs.advance();
      return inputs.pointers.brush!.guessed;
    };
    guessedAfter(0, true);
    expect([guessedAfter(0.5, false), guessedAfter(0.5, true)]).toEqual([false, true]);
    expect([guessedAfter(0, true), guessedAfter(0.5, true), guessedAfter(0.5, false)]).toEqual([
      false,
      true,
      false,
    ]);
  });

  it('is none of what points from the eyes', () => {
    const inputs = new TestInputs();
    const look = pinch('right');
    look.guessed = true;
    inputs.change([look]);
    inputs.select(look, true);
    inputs.advance();
    expect(inputs.pointers.brush?.trigger).toBe(1);
    expect(inputs.pointers.brush?.guessed).toBe(false);
  });
});

describe('a press counts after a release was seen', () => {
  const pressed = (): { inputs: TestInputs; right: TestSource } => {
    const right = controller('right');
    const inputs = new TestInputs(right);
    inputs.advance();
    right.trigger = 1;
    inputs.advance();
    expect(inputs.pointers.brush?.trigger).toBe(1);
    return { inputs, right };
  };

  it.each<[string, (inputs: TestInputs, right: TestSource) => void]>([
    [
      'when it comes',
      (inputs, right) => {
        inputs.change([], [right]);
        inputs.change([right]);
      },
    ],
    [
      'when it comes back in sight',
      (inputs, right) => {
        right.tracked = false;
        inputs.advance();
        right.tracked = true;
      },
    ],
    [
      'when the system was in between',
      (inputs) => {
        inputs.show('visible-blurred');
        inputs.show('visible');
      },
    ],
    ['when one jumped', (inputs) => inputs.pointers.disarm()],
  ])('%s', (_when, happens) => {
    const { inputs, right } = pressed();
    happens(inputs, right);
    inputs.advance();
    inputs.advance();
    expect(inputs.pointers.brush?.tracked).toBe(true);
    expect(inputs.pointers.brush?.trigger).toBe(0);
    right.trigger = 0;
    inputs.advance();
    right.trigger = 1;
    inputs.advance();
    expect(inputs.pointers.brush?.trigger).toBe(1);
  });
});
