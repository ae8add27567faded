import { describe, expect, it } from 'vitest';
import { kindOf } from '../input/kinds';
import { tipsFor } from '../input/lessons';
import { addressOf, nodeNames } from '../input/registry-model';
import { layoutOf, profileOf, PROFILES, registered, type Layout, type Profile } from './registry';

const SIDES = ['left', 'right'] as const;
const HANDS = ['generic-fixed-hand', 'generic-hand', 'generic-hand-select',
  'generic-hand-select-grasp', 'meta-fixed-hand', 'oculus-hand']; // prettier-ignore
const isHand = ({ profileId }: Profile): boolean => HANDS.includes(profileId);
/** A finger on a phone is not tracked. */
const TRACKED = PROFILES.filter(({ profileId }) => profileId !== 'generic-touchscreen');
const CASES = TRACKED.flatMap((profile) =>
  SIDES.map((side) => [profile.profileId, side, profile] as const),
);

const deviceOf = (profile: Profile, side: XRHandedness) => {
  const source = registered(profile.profileId, side);
  return kindOf(source.xr)!.device(source.xr);
};

/** Position of a component's button in the gamepad, −1 where it has none. */
const buttonOf = ({ components, gamepad }: Layout, name: string): number =>
  components[name] ? (gamepad?.buttons.indexOf(name) ?? -1) : -1;

describe('the profiles of the registry', () => {
  it('are all there', () => {
    expect(PROFILES).toHaveLength(46);
  });

  it.each(CASES)('%s (%s) is a hand or a controller by its profile, with joints or without', (id, side, profile) => {
    for (const joints of [false, true]) {
      const source = registered(id, side, joints);
      const few = source.gamepad!.buttons.length < 2 && source.gamepad!.axes.length === 0;
      const hand = isHand(profile) || (joints && few);
      expect(kindOf(source.xr)?.name).toBe(hand ? 'hand' : 'controller');
    }
  }); // prettier-ignore

  it.each(CASES)('%s (%s) paints with the component that selects', (_, side, profile) => {
    const layout = layoutOf(profile, side);
    const { trigger } = deviceOf(profile, side);
    expect(layout.gamepad!.buttons[trigger]).toBe(layout.selectComponentId);
  });

  it.each(CASES)('%s (%s) has a grip, a stick and a pad where the layout has one', (_, side, profile) => {
    if (isHand(profile)) return;
    const layout = layoutOf(profile, side);
    const device = deviceOf(profile, side);
    expect(device.squeeze).toBe(buttonOf(layout, 'xr-standard-squeeze'));
    for (const [kind, name] of [['stick', 'xr-standard-thumbstick'], ['touchpad', 'xr-standard-touchpad']] as const) {
      const places = [device, ...(device.second ? [device.second] : [])];
      const place = places.find(({ pad }) => pad === kind);
      expect(place?.press ?? -1).toBe(buttonOf(layout, name));
      if (place) expect(place.axes.map((axis) => layout.gamepad?.axes[axis]?.componentId)).toEqual([name, name]);
    }
  }); // prettier-ignore

  it.each(CASES)('%s (%s) has the buttons that its hints name, and no others', (_, side, profile) => {
    const { buttons } = layoutOf(profile, side).gamepad!;
    const device = deviceOf(profile, side);
    const at = side === 'left' ? 1 : 0;
    for (const [button, names] of [[device.primary, device.primaryName], [device.secondary, device.secondaryName]] as const) {
      const name = names[at];
      if (button < 0) expect(name).toBe('');
      else expect(buttons[button]).toBe(`${name.toLowerCase()}-button`);
    }
  }); // prettier-ignore

  it.each(CASES)('%s (%s) has a hint for eraser and undo, or the panel only, and none names what is not there', (_, side, profile) => {
    const device = deviceOf(profile, side);
    const layout = layoutOf(profile, side);
    const named: Record<string, string> = {
      Trigger: layout.selectComponentId, Pinch: layout.selectComponentId, Grip: 'xr-standard-squeeze',
      Stick: 'xr-standard-thumbstick', Pad: 'xr-standard-touchpad',
      A: 'a-button', B: 'b-button', X: 'x-button', Y: 'y-button',
    }; // prettier-ignore
    for (const part of ['brush', 'other'] as const) {
      const tips = tipsFor(device, part, side === 'left');
      for (const { text } of tips) {
        const used = text.split(':')[0]!.match(/[A-Z][a-z]*/g)!;
        for (const word of used) {
          if (word !== 'Half') expect(layout.gamepad!.buttons, text).toContain(named[word]);
        }
      }
      const lessons = new Set(tips.map(({ lesson }) => lesson));
      const buttons = device.pad !== 'none' && (device.squeeze >= 0 || device.secondary >= 0);
      if (buttons && part === 'brush') expect(lessons).toContain('undo');
    }
  }); // prettier-ignore

  it('give an Index its A, and undo where it has no B', () => {
    const device = deviceOf(profileOf('valve-index'), 'right');
    const texts = tipsFor(device, 'brush', false).map(({ text }) => text);
    expect(texts).toContain('A: eraser');
    expect(texts).toContain('Grip + Stick ←: undo');
  }); // prettier-ignore

  it('that an Index, a Vive wand or a Magic Leap 2 with joints names keeps its buttons', () => {
    for (const id of ['valve-index', 'htc-vive', 'magicleap-two']) {
      const source = registered(id, 'right', true);
      const kind = kindOf(source.xr)!;
      const device = kind.device(source.xr);
      expect([kind.name, device.pad !== 'none', device.squeeze]).toEqual(['controller', true, 1]);
    }
  });
});

describe('the models of the registry', () => {
  const MODELS = import.meta.glob<Profile>(
    '/node_modules/@webxr-input-profiles/assets/dist/profiles/*/profile.json',
    { eager: true, import: 'default' },
  );
  const BUNDLED = ['htc-vive', 'meta-quest-touch-plus', 'oculus-touch-v3', 'pico-4u'];
  const CONTROLS = BUNDLED.flatMap((id) => SIDES.map((side) => [id, side] as const));

  it.each(CONTROLS)('%s (%s) has a node for each control that a hint points at', (id, side) => {
    const profile = Object.values(MODELS).find(({ profileId }) => profileId === id)!;
    const nodes = JSON.stringify(layoutOf(profile, side));
    const device = deviceOf(profileOf(id), side);
    const names = nodeNames(device, side === 'right');
    const spots = [...tipsFor(device, 'brush', side === 'left'), ...tipsFor(device, 'other', side === 'left')];
    for (const { spot } of spots) expect(nodes).toContain(`"${names[spot]}_value"`);
    expect(addressOf(registered(id, side).xr)).toMatch(/\.glb/);
  }); // prettier-ignore

  it('stand for devices that name a bundled profile as their fallback, and for no others', () => {
    const of = (id: string) => addressOf(registered(id, 'right').xr);
    expect(of('meta-quest-touch-plus-v2')).toBe(of('meta-quest-touch-plus'));
    expect([of('valve-index'), of('generic-hand')]).toEqual([undefined, undefined]);
  });
});
