import { describe, expect, it } from 'vitest';
import { deviceFor } from './devices';
import { controller } from './kinds';
import { Pointer } from './pointer';
import { Poses } from './poses';
import { Rig } from '../moving/rig';

/** Profiles in the order of browsers: the controller's own, then its fallbacks. */
const CONTROLLERS: readonly (readonly [string, readonly string[], number, string])[] = [
  ['Quest 3', ['meta-quest-touch-plus', 'oculus-touch-v3', 'generic-trigger-squeeze-thumbstick'], 4, 'touch'], // prettier-ignore
  ['Index', ['valve-index', 'generic-trigger-squeeze-touchpad-thumbstick'], 4, 'index'],
  ['WMR', ['windows-mixed-reality', 'generic-trigger-squeeze-touchpad-thumbstick'], 4, 'wmr'],
  ['an unheard-of WMR', ['acme-mr', 'generic-trigger-squeeze-touchpad-thumbstick'], 4, 'wmr'],
  ['Vive', ['htc-vive', 'generic-trigger-squeeze-touchpad'], 2, 'vive'],
  ['Vive Focus', ['htc-vive-focus', 'generic-trigger-touchpad'], 2, 'focus'],
  ['a stick without a grip', ['acme-toy', 'generic-trigger-thumbstick'], 4, 'stick'],
  ['a lone trigger', ['acme-wand', 'generic-trigger'], 0, 'wand'],
  ['an unknown stick', ['acme'], 4, 'touch'],
  ['an unknown pad', ['acme'], 2, 'vive'],
];

/** Eyes of a person looking ahead. */
const EYES = new Rig();

const NAMES = ['trigger', 'squeeze', 'touchpad', 'stick', 'a', 'b'] as const;
type Pressed = Partial<Record<(typeof NAMES)[number], number>>;

/** A controller that was let go, and then says this in one frame. */
function holding(profiles: readonly string[], pressed: Pressed, axes: number[]): Pointer {
  const buttons = NAMES.map(() => ({ value: 0, pressed: false }));
  const gamepad = { axes: axes.map(() => 0), buttons };
  const source = { profiles, gamepad, targetRaySpace: {} } as unknown as XRInputSource;
  const matrix = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
  const poses = new Poses({} as unknown as XRSpace);
  const pointer = new Pointer(source, controller, 0, true, poses.add(source));
  const frame = { getPose: () => ({ transform: { matrix } }) } as unknown as XRFrame;
  const rig = pointer.grip.matrix.clone();
  poses.read(frame, {} as unknown as XRReferenceSpace);
  pointer.update(poses, rig, EYES);
  gamepad.axes = axes;
  NAMES.forEach((name, i) => (buttons[i]!.value = pressed[name] ?? 0));
  pointer.update(poses, rig, EYES);
  return pointer;
}

const profilesOf = (name: string): readonly string[] =>
  CONTROLLERS.find(([other]) => other === name)![1];

describe('controllers', () => {
  it.each(CONTROLLERS)('%s is known by its profiles', (_name, profiles, axes, id) => {
    expect(deviceFor(profiles, axes, false).id).toBe(id);
  });

  it.each(['Quest 3', 'Index', 'WMR', 'a stick without a grip'])(
    '%s steps frames by its stick',
    (name) => {
      const hand = holding(profilesOf(name), { trigger: 0.5 }, [0, 0, 1, 0]);
      expect(hand.pad.x).toBeGreaterThan(0.9);
      expect(hand.trigger).toBe(0.5);
      expect(holding(profilesOf(name), { stick: 1 }, [0, 0, 0, 0]).edge.press).toBe(1);
    },
  );

  it.each(['Index', 'WMR'])('%s has a touchpad as well, which counts when pressed', (name) => {
    expect(holding(profilesOf(name), {}, [0.9, 0, 0, 0]).pad.x).toBe(0);
    expect(holding(profilesOf(name), { touchpad: 1 }, [0.9, 0, 0, 0]).pad.x).toBe(1);
    expect(holding(profilesOf(name), { touchpad: 1 }, [0, 0, 0, 0]).edge.press).toBe(1);
    // The stick is heard while the touchpad is only touched.
    expect(holding(profilesOf(name), {}, [0.9, 0, -1, 0]).pad.x).toBeLessThan(-0.9);
  });

  it.each(['Vive', 'Vive Focus'])('%s steps frames by the quadrants of its pad', (name) => {
    expect(holding(profilesOf(name), { touchpad: 1 }, [-0.8, 0.1]).pad.x).toBe(-1);
    expect(holding(profilesOf(name), {}, [-0.8, 0.1]).pad.x).toBe(0);
  });

  it.each(['Quest 3', 'Index', 'WMR', 'Vive'])('%s takes hold by its grip', (name) => {
    expect(holding(profilesOf(name), { squeeze: 1 }, [0, 0, 0, 0]).squeeze.down).toBe(true);
  });

  it('without a grip a squeeze is never felt, whatever stands in its place', () => {
    const hand = holding(profilesOf('Vive Focus'), { squeeze: 1 }, [0, 0]);
    expect(hand.squeeze.down).toBe(false);
    expect(hand.hasGrip).toBe(false);
  });

  it('buttons are read only where the controller has them', () => {
    expect(holding(profilesOf('Index'), { a: 1, b: 1 }, [0, 0, 0, 0]).edge.primary).toBe(1);
    // On Windows Mixed Reality the fifth button is the system's menu.
    expect(holding(profilesOf('WMR'), { a: 1 }, [0, 0, 0, 0]).edge.primary).toBe(0);
  });

  it('what a runtime leaves out counts as at rest', () => {
    const axes = [null, null, null, null] as unknown as number[];
    const hand = holding(profilesOf('Quest 3'), {}, axes);
    expect([hand.pad.x, hand.pad.y, hand.trigger]).toEqual([0, 0, 0]);
  });
});
