import { expect, it } from 'vitest';
import { padName, tipsFor } from '../input/lessons';
import { objectText } from '../painting/tip-sign';
import { state } from '../../store/state';
import { Bench } from './bench';
import { gesturesOf, perform, type Gesture } from './gestures';
import type { TestSource } from './sources';
import { WORN_DEVICES } from './worn-devices';

/** Gestures of a hint, as the table names them: `Grip + Pad ← →: …` is two. */
function named(hint: string): string[] {
  const [control = ''] = hint.toLowerCase().split(':');
  const [, pad, arrows] = /^(.*(?:pad|stick)) ([←→↑↓ ]+)$/.exec(control) ?? [];
  return pad && arrows ? arrows.split(' ').map((arrow) => `${pad} ${arrow}`) : [control];
}

/** Gestures by which hints promise an undo, a redo or an object. */
function promised(bench: Bench): Map<string, string> {
  const { brush, other } = bench.inputs.pointers;
  const found = new Map<string, string>();
  for (const [hand, part] of [[brush, 'brush'], [other, 'other']] as const) {
    if (!hand) continue;
    for (const { text } of tipsFor(hand.device, part, hand.side === 'left')) {
      const act = text.split(': ')[1]!;
      if (!['undo', 'redo'].includes(act)) continue;
      for (const control of named(text)) found.set(`${part} ${control}`, act);
    }
  }
  const sign = objectText(brush!.device, false);
  const offer = /Hold Trigger, (.*): object/.exec(sign)?.[1];
  if (offer) found.set(`brush trigger + ${offer.toLowerCase()}`, 'stroke_begin');
  return found;
} // prettier-ignore

/** The gesture in the words of a hint; a touchpad beside the stick has the stick's functions. */
function keyOf({ name, other, hand }: Gesture): string {
  const control = hand.device.second ? name.replace('pad', 'stick') : name;
  return `${other ? 'other' : 'brush'} ${control}`.toLowerCase();
}

/** Results of each gesture after a stroke, with and without an offered object. */
function afterStrokes(sources: TestSource[], offered: boolean) {
  const bench = new Bench(...sources);
  state.brush.value = { ...state.brush.value, complete: offered };
  const results = gesturesOf(bench).map((gesture) => {
    bench.stroke();
    expect(state.object.value?.completes ?? false).toBe(offered);
    const hint = promised(bench).get(keyOf(gesture));
    const edits = bench.edits.length;
    bench.acted.length = 0;
    perform(bench, gesture);
    return { ...gesture, hint, acted: [...bench.acted], edits: bench.edits.slice(edits) };
  });
  bench.dispose();
  state.brush.value = { ...state.brush.value, complete: true };
  return results;
}

it.each(WORN_DEVICES)('%s: after a stroke labels change by the gestures that hints name alone', (_, sources) => {
  const plain = afterStrokes(sources(), false);
  afterStrokes(sources(), true).forEach(({ hint, acted, edits, ...gesture }, number) => {
    const key = keyOf(gesture);
    // With the trigger held a stroke is painted as well.
    const expected = [...(gesture.held ? ['stroke_begin'] : []), ...(hint ? [hint] : [])];
    expect(edits, key).toEqual(expected);
    // An offer changes the meaning of no control.
    if (!gesture.held) expect(acted, key).toEqual(plain[number]!.acted);
  });
}); // prettier-ignore

it.each(WORN_DEVICES)('%s: an offer is named by a control that is there, and ends by itself', (_, sources) => {
  const bench = new Bench(...sources());
  const { device } = bench.inputs.pointers.brush!;
  bench.stroke();
  const control = device.pad === 'none' ? 'Palette, Tools' : `Hold Trigger, ${padName(device)} ↑`;
  expect(objectText(device, false)).toBe(`1 of 3 · 10 points\n${control}: object`);
  bench.go(250);
  expect(state.object.value).toBeNull();
  expect(bench.edits).toEqual(['stroke_begin']);
  bench.dispose();
}); // prettier-ignore
