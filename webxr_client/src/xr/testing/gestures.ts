/** For tests: every gesture of an input source, tried one after the other, and the actions it brings. */
import type { Device, PadPlace } from '../input/devices';
import type { Pointer } from '../input/pointer';
import type { Bench } from './bench';
import type { TestSource } from './sources';

/** Actions of a person, as the table of devices names them. */
export const ACTIONS = ['enter', 'paint', 'erase', 'undo', 'label', 'step', 'play', 'track', 'question',
  'panels', 'object level', 'another recording', 'leave'] as const; // prettier-ignore
export type Action = (typeof ACTIONS)[number];

export interface Gesture {
  readonly name: string;
  /** Of the hand that does not paint. */
  readonly other: boolean;
  readonly hand: Pointer;
  readonly buttons: readonly number[];
  /** The trigger is held meanwhile. */
  readonly held: boolean;
  readonly axes: readonly (readonly [axis: number, value: number])[];
}

type Plain = Pick<Gesture, 'name' | 'buttons' | 'axes'>;

const ARROWS = { '←': [-1, 0], '→': [1, 0], '↑': [0, -1], '↓': [0, 1], pressed: [0, 0] } as const;

function onPad({ pad, axes, press }: PadPlace): Plain[] {
  if (pad === 'none') return [];
  const name = pad === 'stick' ? 'stick' : 'pad';
  return Object.entries(ARROWS).map(([arrow, [x, y]]) => ({
    name: `${name} ${arrow}`,
    buttons: pad === 'touchpad' || arrow === 'pressed' ? [press] : [],
    axes: [
      [axes[0], x],
      [axes[1], y],
    ],
  }));
}

/** Gestures of a controller besides its trigger: plain ones, then gestures with the grip held. */
function plainGestures(device: Device, side: 0 | 1): Plain[] {
  const named = [
    [device.primary, device.primaryName[side]],
    [device.secondary, device.secondaryName[side]],
  ] as const;
  const buttons = named.flatMap(([button, name]) =>
    button < 0 ? [] : [{ name, buttons: [button], axes: [] }],
  );
  const pads = padGestures(device);
  if (device.squeeze < 0) return [...buttons, ...pads];
  const gripped = pads.map(({ name, buttons: pressed, axes }) => {
    return { name: `grip + ${name}`, buttons: [device.squeeze, ...pressed], axes };
  });
  return [...buttons, ...pads, ...gripped];
}

function padGestures(device: Device): Plain[] {
  return [...onPad(device), ...(device.second ? onPad(device.second) : [])];
}

/** All gestures of the hands that are there. */
export function gesturesOf(bench: Bench): Gesture[] {
  const { brush, other } = bench.inputs.pointers;
  return [brush, other].flatMap((hand) => {
    if (!hand?.source.gamepad || !hand.holds) return [];
    const rest = { hand, other: hand === other };
    const plain = plainGestures(hand.device, hand.side === 'left' ? 1 : 0);
    const held = hand === brush ? padGestures(hand.device) : [];
    return [
      ...plain.map((each) => ({ ...each, ...rest, held: false })),
      ...held.map((each) => ({ ...each, ...rest, held: true, name: `trigger + ${each.name}` })),
    ];
  });
}

/** Make a gesture and undo it again: each of its buttons, and a rest before the next one. */
export function perform(bench: Bench, { hand, buttons, axes, held }: Gesture): void {
  const source = hand.source as unknown as TestSource;
  if (held) bench.trigger(true);
  // The grip is there before the pad is pressed.
  for (const button of buttons.slice(0, -1)) source.press(button, 1);
  bench.go();
  for (const [axis, value] of axes) source.gamepad!.axes[axis] = value;
  for (const button of buttons) source.press(button, 1);
  bench.go(2);
  for (const [axis] of axes) source.gamepad!.axes[axis] = 0;
  for (const button of buttons) source.press(button, 0);
  bench.go(20);
  if (held) bench.trigger(false);
}

const BROUGHT_BY: Record<string, Action> = {
  toggleEraser: 'erase',
  undo: 'undo',
  selectLabel: 'label',
  step: 'step',
  togglePlay: 'play',
  completeObject: 'object level',
  panels: 'panels',
};

/** Gestures by action: the first one found, with its hand if that does not paint. */
export function waysOf(bench: Bench): Map<Action, string> {
  const found = new Map<Action, string>();
  for (const gesture of gesturesOf(bench)) {
    bench.acted.length = 0;
    perform(bench, gesture);
    for (const name of bench.acted) {
      const action = BROUGHT_BY[name];
      if (!action || found.has(action)) continue;
      found.set(action, gesture.other ? `other hand: ${gesture.name}` : gesture.name);
    }
  }
  return found;
}
