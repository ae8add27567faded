/** Personal settings of the headset; kept in the browser. */
import { signal } from '@preact/signals';
import { keep, keptJson } from './kept';
import { follow } from './watch';

export type Side = 'left' | 'right';

export interface XrSettings {
  /** The hand that paints; the other one holds the palette. */
  readonly hand: Side;
  /** Tip of the brush: a sphere at the tip, or a ray for distant points. */
  readonly tip: 'sphere' | 'ray';
  readonly move: 'teleport' | 'smooth';
  /** Degrees a turn; 0 turns evenly. */
  readonly snap: number;
  /** Narrow the view while one is moved. */
  readonly vignette: boolean;
  readonly seated: boolean;
  /** Request hand tracking at the start of a session; browsers may ask for permission. */
  readonly hands: boolean;
  /** Sounds where a pulse cannot be felt, beside each pulse, or never. */
  readonly sound: 'instead' | 'always' | 'off';
  /** Pixels drawn for one of the display along each side, from the next session on. */
  readonly sharpness: number;
  /** Coarser picture towards the edges of the view, 0 to 1. */
  readonly foveation: number;
  /** Tracking runs stop where they become unsure. */
  readonly stopUnsure: boolean;
  /** Explain the buttons again. */
  readonly tips: boolean;
  /** Lead through the first minute. */
  readonly guide: boolean;
}

export const DEFAULTS: XrSettings = {
  hand: 'right',
  tip: 'sphere',
  move: 'teleport',
  snap: 30,
  vignette: true,
  seated: false,
  hands: true,
  sound: 'instead',
  sharpness: 1,
  foveation: 0.5,
  stopUnsure: true,
  tips: true,
  guide: true,
};

const KEY = 'pointbrush.headset';

export const xrSettings = signal<XrSettings>(load());

follow(() => keep(KEY, JSON.stringify(xrSettings.value)));

export function change(fields: Partial<XrSettings>): void {
  xrSettings.value = { ...xrSettings.peek(), ...fields };
}

function load(): XrSettings {
  const settings: XrSettings = { ...DEFAULTS, ...(keptJson(KEY) as Partial<XrSettings> | null) };
  // Older pages stored the box as a tip, which no longer exists.
  return { ...settings, tip: settings.tip === 'ray' ? 'ray' : 'sphere' };
}
