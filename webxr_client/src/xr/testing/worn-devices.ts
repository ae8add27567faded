/** For tests: the devices of the documentation's table, as their runtimes hand them to a page. */
import { registered } from './registry';
import { TestSource } from './sources';

const both = (id: string, joints = false): TestSource[] => [
  registered(id, 'left', joints),
  registered(id, 'right', joints),
];
const one = (id: string, joints = false): TestSource[] => [registered(id, 'right', joints)];
/** A source of a kind that only selects. */
const only = (mode: string, side: XRHandedness = 'none'): TestSource[] => [
  new TestSource({ mode, side, profile: 'generic-button' }),
];

export const WORN_DEVICES: readonly (readonly [name: string, sources: () => TestSource[]])[] = [
  ['Quest 2', () => both('oculus-touch-v3')],
  ['Quest 3', () => both('meta-quest-touch-plus')],
  ['Quest 3S', () => both('meta-quest-touch-plus-v2')],
  ['Quest Pro', () => both('meta-quest-touch-pro')],
  ['Quest 3, one controller', () => one('meta-quest-touch-plus')],
  ['Vive, two wands', () => both('htc-vive')],
  ['Vive, two wands with joints', () => both('htc-vive', true)],
  ['Vive, one wand', () => one('htc-vive')],
  ['Vive, one wand with joints', () => one('htc-vive', true)],
  ['Index', () => both('valve-index')],
  ['Index with joints', () => both('valve-index', true)],
  ['Index, one controller', () => one('valve-index')],
  ['Windows MR', () => both('microsoft-mixed-reality')],
  ['HP Reverb G2', () => both('hp-mixed-reality')],
  ['Pico 4', () => both('pico-4')],
  ['Vive Focus 3', () => both('htc-vive-focus-3')],
  ['Galaxy XR', () => both('samsung-galaxyxr')],
  ['Magic Leap 2', () => one('magicleap-two', true)],
  ['Logitech MX Ink', () => one('logitech-mx-ink')],
  ['Oculus Go', () => one('oculus-go')],
  ['Vision Pro', () => only('transient-pointer', 'right')],
  ['bare hands', () => both('generic-hand-select', true)],
  ['gaze', () => only('gaze')],
  ['phone', () => only('screen')],
];
