/** The kinds of WebXR input that are known, and the table in which an input source finds its own. */
import { Group } from 'three';
import { deviceFor, isHandProfile } from './devices';
import { HandModel } from './hand-model';
import { buttonValue, type Kind, SELECTS } from './kind';
import { controllerModel, disposeModel, drawnSpots } from './model';
import { replaceModel } from './registry-model';

/** Buttons that only controllers have: a hand's gamepad holds at most its pinch. */
const CONTROLLER_BUTTONS = 2;

/**
 * Whether a tracked source is a bare hand.  Held controllers have joints as well in some runtimes
 * (SteamVR, Magic Leap), so `hand` alone tells nothing: the gamepad decides, then the profile.
 */
function isBareHand({ hand, gamepad, profiles }: XRInputSource): boolean {
  const buttons = gamepad?.buttons.length ?? 0;
  const axes = gamepad?.axes.length ?? 0;
  if (hand && buttons < CONTROLLER_BUTTONS && axes === 0) return true;
  return isHandProfile(profiles);
}

/** A controller held in the hand: an analog trigger, buttons and a stick or pad. */
export const controller: Kind = {
  name: 'controller',
  is: (source) => source.targetRayMode === 'tracked-pointer' && !isBareHand(source),
  reach: 'near',
  momentary: false,
  holds: true,
  drawn: true,
  systemPinch: false,
  fleeting: false,
  device: ({ profiles, gamepad }) => deviceFor(profiles, gamepad?.axes.length ?? 0, false),
  // Without a trigger that is pressed by degrees, the events tell as well.
  press: (gamepad, device, selecting) => {
    const analog = device.trigger === 0 && gamepad?.buttons[0];
    return Math.max(buttonValue(gamepad, device.trigger), selecting && !analog ? 1 : 0);
  },
  model: (source, device) => {
    const object = new Group().add(controllerModel());
    const spots = drawnSpots();
    const giveUp = replaceModel(object, spots, source, device);
    const dispose = (): void => {
      giveUp();
      disposeModel(object);
    };
    return { object, spots, gripped: true, dispose };
  },
};

/** A bare hand: a pinch presses, a fingertip pokes panels. */
const hand: Kind = {
  name: 'hand',
  is: (source) => source.targetRayMode === 'tracked-pointer' && isBareHand(source),
  reach: 'near',
  momentary: false,
  holds: true,
  drawn: true,
  systemPinch: true,
  fleeting: true,
  device: ({ profiles, gamepad }) => deviceFor(profiles, gamepad?.axes.length ?? 0, true),
  press: (gamepad, device, selecting) =>
    Math.max(buttonValue(gamepad, device.trigger), selecting ? 1 : 0),
  model: ({ hand: joints }) => (joints ? new HandModel(joints) : null),
};

/** Look and pinch: the eyes aim when a pinch begins, the hand drags from there. */
const transient: Kind = {
  ...SELECTS,
  name: 'look and pinch',
  is: (source) => source.targetRayMode === 'transient-pointer',
  momentary: true,
};

/** The head aims, and a button or a word selects. */
const gaze: Kind = {
  ...SELECTS,
  name: 'gaze',
  is: (source) => source.targetRayMode === 'gaze',
  momentary: false,
};

/** A finger on the screen of a phone that one holds up. */
const screen: Kind = {
  ...SELECTS,
  name: 'touch',
  is: (source) => source.targetRayMode === 'screen',
  momentary: true,
};

/** Kinds by priority: a new pinch is intended, and a controller is more precise than a hand. */
export const KINDS: readonly Kind[] = [transient, controller, hand, gaze, screen];

/** The kind of an input source, or undefined. */
export function kindOf(source: XRInputSource): Kind | undefined {
  return KINDS.find((kind) => kind.is(source));
}

/** Notice about an input that no kind is for. */
export function unknownInput({ targetRayMode, profiles }: XRInputSource): string {
  const named = profiles[0] ? ` (${profiles[0]})` : '';
  return `Unknown kind of input:\n${targetRayMode}${named}`;
}
