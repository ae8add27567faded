import { describe, expect, it } from 'vitest';
import { Controllers } from './controllers';
import { Poses } from './poses';
import { Rig } from './rig';
import { Lessons } from './lessons';

const SQUEEZE = 'generic-trigger-squeeze-touchpad';
const GRIPLESS = 'generic-trigger-touchpad';

/** Both hands hold a controller of a profile; nothing is pressed. */
function holding(profile: string, say: (text: string) => void = () => undefined): Controllers {
  const session = { addEventListener: () => undefined } as unknown as XRSession;
  const changes = { brushGone: () => undefined, say };
  const controllers = new Controllers(
    session,
    new Poses({} as unknown as XRSpace),
    new Rig(),
    new Lessons(),
    changes,
  );
  for (const hand of controllers.both) {
    hand.attach({ profiles: [profile] } as unknown as XRInputSource);
    hand.tracked = true;
  }
  return controllers;
}

describe('taking hold of the room', () => {
  it('is the grip, on either hand, also while the trigger paints', () => {
    const controllers = holding(SQUEEZE);
    controllers.brush.squeeze.update(1);
    controllers.other.click.update(1);
    expect(controllers.holds(controllers.brush, true)).toBe(true);
    expect(controllers.holds(controllers.other, false)).toBe(false);
  });

  it('is the trigger of the hand that does not paint where there is no grip', () => {
    const controllers = holding(GRIPLESS);
    controllers.brush.click.update(1);
    controllers.other.click.update(1);
    expect(controllers.holds(controllers.brush, false)).toBe(false);
    expect(controllers.holds(controllers.other, false)).toBe(true);
    // Both triggers make a box, and a panel is pressed with the same one.
    expect(controllers.holds(controllers.other, true)).toBe(false);
    controllers.bodyOf(controllers.other).on = {} as never;
    expect(controllers.holds(controllers.other, false)).toBe(false);
  });
});

it('misses a controller once that the headset has not seen for a second', () => {
  const said: string[] = [];
  const controllers = holding(SQUEEZE, (text) => said.push(text));
  const { right, left } = controllers.hands;
  left.detach();
  const go = (seconds: number): void => {
    const none = {} as never;
    controllers.update(none, none, Float64Array.of(seconds));
  };
  right.trigger = 1;
  go(0.4);
  expect([right.tracked, right.trigger, said]).toEqual([false, 0, []]);
  for (let i = 0; i < 5; i++) go(0.4);
  expect(said).toEqual(['The headset does not see the right controller']);
});
