/** For tests: every gesture of an input source, tried one after the other, and the actions it brings. */
import { vi } from 'vitest';
import { bindActions } from '../../store/actions';
import type { Label } from '../../protocol/messages';
import { state } from '../../store/state';
import { Buttons, LabelSwitch } from '../input/buttons';
import type { Device, PadPlace } from '../input/devices';
import { Lessons } from '../input/lessons';
import type { Pointer } from '../input/pointer';
import type { TestSource, Worn } from './sources';

/** Actions of a person, as the table of devices names them. */
export const ACTIONS = ['enter', 'paint', 'erase', 'undo', 'label', 'step', 'play', 'track', 'question',
  'panels', 'object level', 'another recording', 'leave'] as const; // prettier-ignore
export type Action = (typeof ACTIONS)[number];

interface Gesture {
  readonly name: string;
  readonly buttons: readonly number[];
  readonly axes?: readonly (readonly [axis: number, value: number])[];
}

const ARROWS = { '←': [-1, 0], '→': [1, 0], '↑': [0, -1], '↓': [0, 1], pressed: [0, 0] } as const;

function onPad({ pad, axes, press }: PadPlace): Gesture[] {
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

/** Gestures of a controller besides its trigger: the plain ones before those with the grip held. */
function gesturesOf(device: Device, side: 0 | 1): Gesture[] {
  const named = [
    [device.primary, device.primaryName[side]],
    [device.secondary, device.secondaryName[side]],
  ] as const;
  const buttons = named.flatMap(([button, name]) =>
    button < 0 ? [] : [{ name, buttons: [button] }],
  );
  const pads = [...onPad(device), ...(device.second ? onPad(device.second) : [])];
  if (device.squeeze < 0) return [...buttons, ...pads];
  const gripped = pads.map(({ name, buttons: pressed, ...rest }) => {
    return { name: `grip + ${name}`, buttons: [device.squeeze, ...pressed], ...rest };
  });
  return [...buttons, ...pads, ...gripped];
}

/** Gestures by action: the first one found, with its hand if that does not paint. */
export function waysOf(worn: Worn): Map<Action, string> {
  const found = new Map<Action, string>();
  let gesture = '';
  const brings = (action: Action) => (): false => {
    if (!found.has(action)) found.set(action, gesture);
    return false;
  };
  const unbind = bindActions({
    toggleEraser: brings('erase'),
    undo: brings('undo'),
    selectLabel: brings('label'),
    step: brings('step'),
    togglePlay: brings('play'),
    completeObject: () => false,
    stepObject: brings('object level'),
  });
  state.palette.value = [1, 2, 3].map((id) => ({ id }) as Label);
  state.activeLabel.value = 1;
  const buttons = new Buttons(new Lessons(), brings('panels'), vi.fn());
  const labels = new LabelSwitch();
  let now = 0;
  const picture = (): void => {
    now += 1000;
    worn.go();
    const { brush, other } = worn.pointers;
    for (const hand of [brush, other]) {
      if (hand) labels.update(hand, worn.pointers.partOf(hand), false, now);
    }
    buttons.update(brush, other, Float64Array.of(0.01), now);
  };
  const perform = (pointer: Pointer, { name, buttons: pressed, axes = [] }: Gesture): void => {
    gesture = pointer === worn.pointers.brush ? name : `other hand: ${name}`;
    const source = pointer.source as unknown as TestSource;
    // The grip is there before the pad is pressed.
    for (const button of pressed.slice(0, -1)) source.press(button, 1);
    picture();
    for (const [axis, value] of axes) source.gamepad!.axes[axis] = value;
    for (const button of pressed) source.press(button, 1);
    picture();
    for (const [axis] of axes) source.gamepad!.axes[axis] = 0;
    for (const button of pressed) source.press(button, 0);
    picture();
  };
  picture();
  for (const object of [null, { levels: 3, level: 1, points: 9, ready: true, taken: true, completes: false }]) {
    state.object.value = object;
    for (const hand of [worn.pointers.brush, worn.pointers.other]) {
      if (!hand?.source.gamepad || !hand.holds) continue;
      for (const each of gesturesOf(hand.device, hand.side === 'left' ? 1 : 0)) perform(hand, each);
    }
  } // prettier-ignore
  state.object.value = null;
  unbind();
  return found;
}
