/** Controllers as data: which button and axis is what, by WebXR input profile. */

export type PadKind = 'stick' | 'touchpad' | 'none';

export interface Device {
  readonly id: string;
  /** Input profiles that this row is for, most specific first. */
  readonly profiles: readonly string[];
  readonly pad: PadKind;
  /** Positions in `gamepad.axes`. */
  readonly axes: readonly [number, number];
  /** Positions in `gamepad.buttons`; −1 where there is none. */
  readonly trigger: number;
  readonly squeeze: number;
  readonly press: number;
  readonly primary: number;
  readonly secondary: number;
  /** Names printed on the buttons of the right and the left controller. */
  readonly primaryName: readonly [right: string, left: string];
  readonly secondaryName: readonly [right: string, left: string];
  /** Metres from the pointing ray's origin to the tip where the brush begins. */
  readonly tip: number;
}

const NONE = ['', ''] as const;

/** Buttons and axes as in the `xr-standard` mapping of the WebXR Gamepads Module. */
const STICK = {
  pad: 'stick', axes: [2, 3], trigger: 0, squeeze: 1, press: 3, primary: 4, secondary: 5,
  tip: 0.04,
} as const; // prettier-ignore

const TOUCHPAD = {
  pad: 'touchpad', axes: [0, 1], trigger: 0, squeeze: 1, press: 2, primary: -1, secondary: -1,
  primaryName: NONE, secondaryName: NONE, tip: 0.04,
} as const; // prettier-ignore

export const DEVICES: readonly Device[] = [
  {
    ...STICK,
    id: 'touch',
    profiles: ['meta-quest-touch-plus', 'meta-quest-touch-pro', 'oculus-touch-v3',
      'oculus-touch-v2', 'oculus-touch', 'pico-4', 'pico-neo3'],
    primaryName: ['A', 'X'],
    secondaryName: ['B', 'Y'],
  },
  {
    ...STICK,
    id: 'index',
    profiles: ['valve-index'],
    primaryName: ['A', 'A'],
    secondaryName: ['B', 'B'],
  },
  { ...TOUCHPAD, id: 'vive', profiles: ['htc-vive', 'generic-trigger-squeeze-touchpad'] },
  { ...STICK, id: 'wmr', profiles: ['microsoft-mixed-reality', 'windows-mixed-reality'],
    primary: -1, secondary: -1, primaryName: NONE, secondaryName: NONE },
  { ...TOUCHPAD, id: 'focus', profiles: ['htc-vive-focus', 'generic-trigger-touchpad'],
    squeeze: -1 },
  {
    ...STICK,
    id: 'hand',
    profiles: ['generic-hand-select', 'generic-hand'],
    pad: 'none', squeeze: -1, press: -1, primary: -1, secondary: -1,
    primaryName: NONE, secondaryName: NONE, tip: 0,
  },
  {
    ...STICK,
    id: 'standard',
    profiles: ['generic-trigger-squeeze-thumbstick', 'generic-trigger-thumbstick'],
    primaryName: ['A', 'X'],
    secondaryName: ['B', 'Y'],
  },
]; // prettier-ignore

/** The row for an input source; unknown ones are told apart by their number of axes. */
export function deviceFor(profiles: readonly string[], axes: number, isHand: boolean): Device {
  const named = (id: string): Device => DEVICES.find((device) => device.id === id)!;
  if (isHand) return named('hand');
  for (const profile of profiles) {
    const found = DEVICES.find((device) => device.profiles.includes(profile));
    if (found) return found;
  }
  if (axes >= 4) return named('standard');
  return axes >= 2 ? named('vive') : named('hand');
}
