/** Page of the palette for comfort in the headset: moving, holding, showing. */
import { change, xrSettings, type XrSettings } from '../../../store/xr-settings';
import type { Ui } from '../../drawing/ui';

/** Degrees that one turns by at a flick of the stick; 0: evenly, as long as it leans. */
const TURNS = [30, 45, 90, 0] as const;

/** The next of some choices, round and round. */
function next<T>(choices: readonly T[], now: T): T {
  return choices[(choices.indexOf(now) + 1) % choices.length]!;
}

/** Checks, two in a row; lengths in ems. */
const [CHECK_PITCH, CHECK_HEIGHT] = [2.2, 2];
const [BUTTON_PITCH, BUTTON_HEIGHT] = [2.5, 2.2];

export function drawComfort(ui: Ui, x: number, top: number, inner: number): void {
  const { em } = ui;
  const half = inner / 2;
  const settings = xrSettings.peek();
  const checks = checksOf(settings);
  checks.forEach(([name, on, fields], i) => {
    const y = top + em * CHECK_PITCH * Math.floor(i / 2);
    ui.check(x + (i % 2) * half, y, half, em * CHECK_HEIGHT, name, on, () => change(fields));
  });
  const below = top + em * (CHECK_PITCH * Math.ceil(checks.length / 2) + 0.6);
  buttonsOf(settings).forEach(([text, fields], i) => {
    const look = { text, strong: true, align: 'left' } as const;
    const y = below + i * em * BUTTON_PITCH;
    ui.button(x, y, inner - em * 0.2, em * BUTTON_HEIGHT, look, () => change(fields));
  });
}

type CheckRow = readonly [name: string, on: boolean, fields: Partial<XrSettings>];

function checksOf(settings: XrSettings): readonly CheckRow[] {
  const { hand, hands, move, vignette, seated, tips, guide } = settings;
  const left = hand === 'left';
  const glides = move === 'smooth';
  return [
    ['Left-handed', left, { hand: left ? 'right' : 'left' }],
    ['Seated', seated, { seated: !seated }],
    ['Glide', glides, { move: glides ? 'teleport' : 'smooth' }],
    ['Vignette', vignette, { vignette: !vignette }],
    ['Button tips', tips, { tips: !tips }],
    ['Bare hands', hands, { hands: !hands }],
    ['First minute', guide, { guide: !guide }],
  ];
}

/** Shares of the display's own pixels, and of the edges' coarseness with its names. */
const SHARPNESS = [0.8, 1, 1.2, 1.4] as const;
const FOVEATION = [0, 0.5, 1] as const;
const SOUNDS = {
  instead: 'Sound without vibration',
  always: 'Sound with each pulse',
  off: 'No sound',
} as const;
const EDGES = ['sharp', 'softer', 'soft'] as const;

function buttonsOf({
  snap,
  sharpness,
  foveation,
  sound,
}: XrSettings): readonly (readonly [string, Partial<XrSettings>])[] {
  const turn = snap > 0 ? `Turn ${snap}°` : 'Turn smoothly';
  const edges = EDGES[FOVEATION.indexOf(foveation as (typeof FOVEATION)[number])] ?? '';
  return [
    [turn, { snap: next<number>(TURNS, snap) }],
    [
      `Sharpness ${Math.round(100 * sharpness)} %, on next entry`,
      { sharpness: next<number>(SHARPNESS, sharpness) },
    ],
    [SOUNDS[sound], { sound: next<XrSettings['sound']>(['instead', 'always', 'off'], sound) }],
    [`Edges ${edges}`, { foveation: next<number>(FOVEATION, foveation) }],
  ];
}
