/**
 * Table of controllers: indices of buttons and axes by WebXR input profile.  Indices follow the
 * `xr-standard` mapping (WebXR Gamepads Module): trigger, squeeze, touchpad, thumbstick, and further
 * buttons; axes of the touchpad, then of the thumbstick.
 */

export type PadKind = 'stick' | 'touchpad' | 'none';

/** Something for the thumb. */
export interface PadPlace {
  readonly pad: PadKind;
  /** Positions in `gamepad.axes`. */
  readonly axes: readonly [number, number];
  /** Position in `gamepad.buttons`; −1 where it cannot be pressed. */
  readonly press: number;
}

export interface Device extends PadPlace {
  readonly id: string;
  /** Input profiles that this row is for, generic ones last. */
  readonly profiles: readonly string[];
  /** Some controllers have a touchpad beside the stick: it works as well. */
  readonly second: PadPlace | null;
  /** Positions in `gamepad.buttons`; −1 where there is none. */
  readonly trigger: number;
  readonly squeeze: number;
  readonly primary: number;
  readonly secondary: number;
  /** Names printed on the buttons of the right and the left controller. */
  readonly primaryName: readonly [right: string, left: string];
  readonly secondaryName: readonly [right: string, left: string];
  /** Metres from the pointing ray's origin to the tip where the brush begins. */
  readonly tip: number;
}

const NO_NAME = ['', ''] as const;
const NO_BUTTONS = {
  primary: -1, secondary: -1, primaryName: NO_NAME, secondaryName: NO_NAME,
} as const; // prettier-ignore
const TOUCHPAD = { pad: 'touchpad', axes: [0, 1], press: 2 } as const;
const STICK = { pad: 'stick', axes: [2, 3], press: 3 } as const;
const GRIPPED = { trigger: 0, squeeze: 1, second: null, tip: 0.04 } as const;
const GRIPLESS = { ...GRIPPED, squeeze: -1 } as const;
const BUTTONS = {
  primary: 4, secondary: 5, primaryName: ['A', 'X'], secondaryName: ['B', 'Y'],
} as const; // prettier-ignore

export const DEVICES: readonly Device[] = [
  {
    ...STICK, ...GRIPPED, ...BUTTONS,
    id: 'touch',
    profiles: ['meta-quest-touch-plus-v2', 'meta-quest-touch-plus', 'meta-quest-touch-pro',
      'oculus-touch-v3', 'oculus-touch-v2', 'oculus-touch', 'pico-4', 'pico-4u', 'pico-neo3',
      'pico-neo2', 'hp-mixed-reality', 'htc-vive-cosmos', 'htc-vive-focus-3',
      'samsung-galaxyxr', 'yvr-touch-v2', 'yvr-touch'],
  },
  {
    ...STICK, ...GRIPPED, ...NO_BUTTONS,
    id: 'gripstick',
    profiles: ['generic-trigger-squeeze-thumbstick'],
  },
  {
    ...STICK, ...GRIPPED, ...BUTTONS,
    id: 'index',
    profiles: ['valve-index'],
    second: TOUCHPAD,
    primaryName: ['A', 'A'],
    // Its B is the system's: browsers give no sixth button.
    secondary: -1,
    secondaryName: NO_NAME,
  },
  {
    ...STICK, ...GRIPPED, ...NO_BUTTONS,
    id: 'wmr',
    profiles: ['microsoft-mixed-reality', 'windows-mixed-reality', 'samsung-odyssey',
      'generic-trigger-squeeze-touchpad-thumbstick'],
    second: TOUCHPAD,
  },
  {
    ...TOUCHPAD, ...GRIPPED, ...NO_BUTTONS,
    id: 'vive',
    profiles: ['htc-vive', 'htc-vive-focus-plus', 'magicleap-one', 'magicleap-two',
      'generic-trigger-squeeze-touchpad'],
  },
  {
    ...TOUCHPAD, ...GRIPLESS, ...NO_BUTTONS,
    id: 'focus',
    profiles: ['htc-vive-focus', 'oculus-go', 'pico-g2', 'samsung-gearvr',
      'generic-trigger-touchpad'],
  },
  {
    ...STICK, ...GRIPLESS, ...NO_BUTTONS,
    id: 'stick',
    profiles: ['generic-trigger-thumbstick'],
  },
  {
    ...STICK, ...GRIPLESS, ...NO_BUTTONS,
    id: 'both',
    profiles: ['generic-trigger-touchpad-thumbstick'],
    second: TOUCHPAD,
  },
  {
    ...GRIPPED, ...NO_BUTTONS,
    id: 'hand',
    profiles: ['generic-hand-select', 'generic-hand-select-grasp', 'generic-hand', 'oculus-hand',
      'generic-fixed-hand', 'meta-fixed-hand'],
    pad: 'none', axes: [2, 3], press: -1, squeeze: -1, tip: 0,
  },
  {
    ...GRIPPED, ...NO_BUTTONS,
    id: 'grip',
    profiles: ['logitech-mx-ink', 'generic-trigger-squeeze'],
    pad: 'none', axes: [2, 3], press: -1,
  },
  {
    ...GRIPLESS, ...NO_BUTTONS,
    id: 'wand',
    profiles: ['generic-trigger', 'generic-button', 'google-daydream'],
    pad: 'none', axes: [2, 3], press: -1,
  },
  {
    ...GRIPLESS, ...NO_BUTTONS,
    id: 'touchpad',
    profiles: ['generic-touchpad'],
    pad: 'none', axes: [0, 1], press: -1, trigger: 2,
  },
]; // prettier-ignore

/** The pad stands in for buttons that a controller lacks, and has more to do, while the grip is held. */
export function chords({ squeeze, pad }: Device): boolean {
  return squeeze >= 0 && pad !== 'none';
}

/** Whether the profiles belong to a bare hand; the first known one decides. */
export function isHandProfile(profiles: readonly string[]): boolean {
  return rowOf(profiles)?.id === 'hand';
}

function rowOf(profiles: readonly string[]): Device | undefined {
  for (const profile of profiles) {
    const found = DEVICES.find((device) => device.profiles.includes(profile));
    if (found) return found;
  }
  return undefined;
}

/**
 * The row for an input source.  `profiles` starts with the most specific name; unknown profiles are
 * distinguished by their number of axes.
 */
export function deviceFor(profiles: readonly string[], axes: number, isHand: boolean): Device {
  const named = (id: string): Device => DEVICES.find((device) => device.id === id)!;
  if (isHand) return named('hand');
  const found = rowOf(profiles);
  if (found) return found;
  if (axes >= 4) return named('touch');
  return axes >= 2 ? named('vive') : named('wand');
}
