import { describe, expect, it } from 'vitest';
import { xrSettings, change as set } from '../../store/xr-settings';
import { registered } from '../testing/registry';
import { TestSource, Worn } from '../testing/sources';

const GRIPLESS = 'generic-trigger-touchpad';
const controller = (side: XRHandedness, profile?: string): TestSource =>
  new TestSource(profile === undefined ? { side } : { side, profile });
const pinch = (side: XRHandedness): TestSource =>
  new TestSource({ mode: 'transient-pointer', side });

describe('taking hold of the room', () => {
  it('is the grip, on either hand, also while the trigger paints', () => {
    const [left, right] = [controller('left'), controller('right')];
    const worn = new Worn(left, right);
    worn.go();
    right.squeeze = 1;
    left.trigger = 1;
    worn.go();
    const { brush, other } = worn.pointers;
    expect(worn.pointers.holds(brush, true, false)).toBe(true);
    expect(worn.pointers.holds(other, false, false)).toBe(false);
  });

  it('is the press of the one that does not paint where there is no grip; the other joins in', () => {
    const [left, right] = [controller('left', GRIPLESS), controller('right', GRIPLESS)];
    const worn = new Worn(left, right);
    worn.go();
    left.trigger = right.trigger = 1;
    worn.go();
    const { brush, other } = worn.pointers;
    expect(worn.pointers.holds(brush, false, false)).toBe(false);
    expect(worn.pointers.holds(brush, false, true)).toBe(true);
    expect(worn.pointers.holds(other, false, false)).toBe(true);
    // Both triggers make a box, and a panel is pressed with the same one.
    expect(worn.pointers.holds(other, true, false)).toBe(false);
    worn.pointers.bodyOf(other!).on = { leave: () => undefined } as never;
    expect(worn.pointers.holds(other, false, false)).toBe(false);
  });
});

describe('who comes and goes', () => {
  it('a hand beside a controller takes nothing from it, and stays when that goes', () => {
    const [right, bare] = [controller('right'), new TestSource({ hand: true })];
    const worn = new Worn(right);
    worn.change([bare]);
    expect(worn.pointers.brush?.source).toBe(right.xr);
    worn.change([], [bare]);
    expect(worn.pointers.brush?.source).toBe(right.xr);
    worn.change([bare], [right]);
    expect(worn.pointers.brush?.source).toBe(bare.xr);
    worn.go(2);
    expect(worn.said).toEqual([]);
    worn.change([], [bare]);
    expect(worn.pointers.brush).toBeNull();
  });

  it('a controller that stays away is missed after a second, one that a menu took is not', () => {
    const right = controller('right');
    const worn = new Worn(right);
    worn.show('visible-blurred');
    worn.change([], [right]);
    worn.go(5);
    worn.show('visible');
    worn.go(0.5);
    worn.change([right]);
    worn.go(2);
    expect(worn.said).toEqual([]);
    worn.change([], [right]);
    worn.go(0.5);
    expect(worn.said).toEqual([]);
    worn.go(0.6);
    expect(worn.said).toEqual([
      'The right controller is disconnected:\npress its system button to switch it on',
    ]);
  });

  it('is told within three seconds that nothing came, with what to do; once, and not where something points', () => {
    const worn = new Worn();
    worn.show('visible-blurred');
    worn.go(5);
    worn.show('visible');
    worn.go(1.5);
    expect(worn.said).toEqual([]);
    worn.go(1.4);
    expect(worn.said).toEqual([
      'Look at a point and pinch,\nhold a hand in front of the headset,\nor press a system button of a controller',
    ]);
    worn.go(5);
    expect(worn.said).toHaveLength(1);
    const [eyes, look] = [new Worn(), pinch('right')];
    eyes.change([look]);
    eyes.go();
    eyes.change([], [look]);
    eyes.go(5);
    expect(eyes.said).toEqual([]);
  });

  it('is told to touch the screen where the session is on one', () => {
    const worn = new Worn();
    worn.session.interactionMode = 'screen-space';
    worn.go(3);
    expect(worn.said).toEqual(['Touch the screen\nwhere you want to paint']);
  });

  it('is noticed within a second where no event tells of it', () => {
    const [left, right] = [controller('left'), controller('right')];
    const worn = new Worn(left);
    worn.arrive([right, new TestSource({ mode: 'brain-waves' })]);
    worn.go(1);
    expect(worn.pointers.brush?.source).toBe(right.xr);
    worn.arrive([], [right]);
    worn.go(1);
    worn.go(1.1);
    expect(worn.pointers.brush?.source).toBe(left.xr);
    expect(worn.said.filter((text) => text.startsWith('Unknown'))).toHaveLength(1);
  });

  it('the wished hand is asked anew, and a trigger that is held does not paint for it', () => {
    const [left, right] = [controller('left'), controller('right')];
    const worn = new Worn(left, right);
    worn.go();
    left.trigger = 1;
    worn.go();
    set({ hand: 'left' });
    worn.pointers.assign();
    worn.go();
    expect(worn.pointers.brush?.source).toBe(left.xr);
    expect(worn.pointers.palette?.source).toBe(right.xr);
    expect(worn.pointers.brush?.trigger).toBe(0);
    set({ hand: 'right' });
    expect(xrSettings.peek().hand).toBe('right');
  });

  it('a press that is told before its source is heard', () => {
    const worn = new Worn();
    const look = pinch('right');
    worn.select(look, true);
    worn.change([look]);
    worn.go();
    expect(worn.pointers.bodies).toHaveLength(1);
    expect(worn.pointers.brush?.edge.click).toBe(1);
  });

  it('a pinch that comes and goes between two pictures is pressed in one and let go in the next', () => {
    const worn = new Worn();
    const look = pinch('right');
    worn.change([look]);
    worn.select(look, true);
    worn.go();
    expect(worn.pointers.brush?.trigger).toBe(1);
    worn.select(look, false);
    worn.change([], [look]);
    look.tracked = false;
    worn.go();
    expect(worn.pointers.brush?.edge.click).toBe(-1);
    worn.go();
    expect(worn.pointers.brush).toBeNull();
  });

  it('what is only tracked does not press, and does once it is held', () => {
    const worn = new Worn(new TestSource({ hand: true }));
    const right = controller('right');
    worn.change([right], [], 'trackedsourceschange');
    expect(worn.pointers.brush?.kind.name).toBe('hand');
    worn.change([right]);
    worn.change([], [right], 'trackedsourceschange');
    expect(worn.pointers.brush?.source).toBe(right.xr);
    expect(worn.pointers.bodies).toHaveLength(2);
  });

  it('an input of a kind that is not known says so', () => {
    const worn = new Worn(new TestSource({ mode: 'brain-waves', profile: 'acme-cap' }));
    expect(worn.pointers.bodies).toHaveLength(0);
    expect(worn.said).toEqual(['Unknown kind of input:\nbrain-waves (acme-cap)']);
  });

  it('a controller is missed once that the headset has not seen for a second', () => {
    const right = controller('right');
    const worn = new Worn(right);
    worn.go();
    right.tracked = false;
    right.trigger = 1;
    worn.go(0.4);
    expect([worn.pointers.brush?.tracked, worn.pointers.brush?.trigger]).toEqual([false, 0]);
    for (let i = 0; i < 5; i++) worn.go(0.4);
    expect(worn.said).toEqual([
      'The headset does not see the right controller:\nhold it in front of the headset',
    ]);
  });
});

it('a press is heard of a pad that tells of it by events alone, a pulled trigger by its value', () => {
  for (const [id, heard] of [['generic-touchpad', 1], ['htc-vive', 0]] as const) {
    const source = registered(id, 'right');
    const worn = new Worn(source);
    worn.go();
    worn.select(source, true);
    worn.go();
    expect(worn.pointers.brush!.trigger, id).toBe(heard);
  }
}); // prettier-ignore

describe('handedness', () => {
  const hands = (): { worn: Worn; left: TestSource; right: TestSource } => {
    const [left, right] = (['left', 'right'] as const).map(
      (side) => new TestSource({ hand: true, side }),
    ) as [TestSource, TestSource];
    return { worn: new Worn(left, right), left, right };
  };
  const paints = ({ pointers }: Worn): string | undefined => pointers.brush?.side;

  it('stays while the wished hand is away for a moment, and the other one paints nothing', () => {
    const { worn, left, right } = hands();
    worn.change([], [right]);
    worn.select(left, true);
    worn.go(0.9);
    expect([paints(worn), worn.pointers.other?.source, worn.said]).toEqual([
      undefined,
      left.xr,
      [],
    ]);
    worn.change([right]);
    worn.go(0.9);
    expect([paints(worn), worn.said]).toEqual(['right', []]);
  });

  it('changes after a second, with a sign, and never in a pinch', () => {
    const { worn, left, right } = hands();
    worn.change([], [right]);
    worn.select(left, true);
    for (let i = 0; i < 3; i++) worn.go(0.9);
    expect(paints(worn)).toBeUndefined();
    worn.select(left, false);
    worn.go();
    worn.go();
    expect([paints(worn), worn.said]).toEqual(['left', ['The left hand paints now']]);
    // It finishes its stroke when the other one is back.
    worn.select(left, true);
    worn.go();
    worn.change([right]);
    worn.go(2);
    expect(paints(worn)).toBe('left');
    worn.select(left, false);
    worn.go();
    worn.go();
    expect([paints(worn), worn.said.at(-1)]).toEqual(['right', 'The right hand paints again']);
  });

  it('is said with the reason where a controller went', () => {
    const [left, right] = [controller('left'), controller('right')];
    const worn = new Worn(left, right);
    worn.change([], [right]);
    worn.go(1.1);
    expect(worn.said.at(-1)).toBe(
      'The right controller is disconnected:\npress its system button to switch it on\nThe left controller paints now',
    );
  });
});

describe('a press where the headset guesses', () => {
  it('is told while it is held, of what is held in a hand', () => {
    const right = controller('right');
    const worn = new Worn(right);
    const told = (trigger: number, guessed: boolean): boolean => {
      Object.assign(right, { trigger, guessed });
      worn.go();
      return worn.pointers.brush!.guessed;
    };
    told(0, true);
    expect([told(0.5, false), told(0.5, true)]).toEqual([false, true]);
    expect([told(0, true), told(0.5, true), told(0.5, false)]).toEqual([false, true, false]);
  });

  it('is none of what points from the eyes', () => {
    const worn = new Worn();
    const look = pinch('right');
    look.guessed = true;
    worn.change([look]);
    worn.select(look, true);
    worn.go();
    expect(worn.pointers.brush?.trigger).toBe(1);
    expect(worn.pointers.brush?.guessed).toBe(false);
  });
});

describe('a press counts after a release was seen', () => {
  const pressed = (): { worn: Worn; right: TestSource } => {
    const right = controller('right');
    const worn = new Worn(right);
    worn.go();
    right.trigger = 1;
    worn.go();
    expect(worn.pointers.brush?.trigger).toBe(1);
    return { worn, right };
  };

  it.each<[string, (worn: Worn, right: TestSource) => void]>([
    [
      'when it comes',
      (worn, right) => {
        worn.change([], [right]);
        worn.change([right]);
      },
    ],
    [
      'when it comes back in sight',
      (worn, right) => {
        right.tracked = false;
        worn.go();
        right.tracked = true;
      },
    ],
    [
      'when the system was in between',
      (worn) => {
        worn.show('visible-blurred');
        worn.show('visible');
      },
    ],
    ['when one jumped', (worn) => worn.pointers.disarm()],
  ])('%s', (_when, happens) => {
    const { worn, right } = pressed();
    happens(worn, right);
    worn.go();
    worn.go();
    expect(worn.pointers.brush?.tracked).toBe(true);
    expect(worn.pointers.brush?.trigger).toBe(0);
    right.trigger = 0;
    worn.go();
    right.trigger = 1;
    worn.go();
    expect(worn.pointers.brush?.trigger).toBe(1);
  });
});
