import { afterEach, describe, expect, it } from 'vitest';
import type { Label } from '../../protocol/messages';
import { state } from '../../store/state';
import { Bench } from '../testing/bench';
import { registered } from '../testing/registry';
import type { TestSource } from '../testing/sources';
import { labelBeside } from './up-down';

const [QUEST, VIVE] = ['meta-quest-touch-plus', 'htc-vive'];
let bench: Bench;

function wear(profile: string, hands: readonly ('left' | 'right')[]): TestSource {
  const sources = hands.map((hand) => registered(profile, hand));
  bench = new Bench(...sources);
  return sources.at(-1)!;
}

afterEach(() => bench.dispose());

/** Let the thumb be at a height of a stick or pad, which is pressed there or not. */
function push(source: TestSource, y: number, pressed = false): void {
  const axes = source.gamepad!.axes;
  axes[axes.length - 1] = y;
  if (axes.length === 2) source.press(2, pressed ? 1 : 0);
  bench.go(2);
}

const active = (): number => state.activeLabel.value;

it.each([[['left', 'right']], [['right']]] as const)('a stick marks a label while it leans and takes it when it is let go: %j', (hands) => {
  const right = wear(QUEST, hands);
  for (const stroke of [false, true]) {
    if (stroke) bench.stroke();
    state.activeLabel.value = 1;
    push(right, 1);
    expect([bench.upDown.shown, bench.upDown.marked, active()]).toEqual([true, 1, 1]);
    push(right, 0);
    expect([bench.upDown.shown, bench.upDown.marked, active()]).toEqual([false, 0, 2]);
    push(right, -1);
    push(right, 0);
    expect(active()).toBe(1);
  }
}); // prettier-ignore

it.each([[['left', 'right']], [['right']]] as const)('a pad marks a label when it is touched and takes it when it is pressed: %j', (hands) => {
  const right = wear(VIVE, hands);
  for (const stroke of [false, true]) {
    if (stroke) bench.stroke();
    state.activeLabel.value = 1;
    push(right, 0.8);
    expect([bench.upDown.shown, bench.upDown.marked, active()]).toEqual([true, 1, 1]);
    push(right, 0.8, true);
    expect(active()).toBe(2);
    push(right, 0);
    expect([bench.upDown.shown, active()]).toEqual([false, 2]);
  }
}); // prettier-ignore

describe('a push', () => {
  it('that is held runs through the labels', () => {
    const right = wear(QUEST, ['right']);
    push(right, 1);
    bench.go(60);
    expect(bench.upDown.marked).toBeGreaterThan(3);
  });

  it('takes its label for the stroke that begins before it ends', () => {
    const right = wear(QUEST, ['right']);
    push(right, 1);
    bench.trigger(true);
    expect(active()).toBe(2);
    const begun = bench.sent.find(({ type }) => type === 'stroke_begin');
    expect(begun).toMatchObject({ brush: { label: 2 } });
    // The rest of the gesture does not choose an object's level either.
    bench.go(60);
    bench.trigger(false);
    expect(bench.edits).toEqual(['stroke_begin']);
  });

  it('takes nothing when the hand is lost or the grip takes over', () => {
    const right = wear(QUEST, ['left', 'right']);
    push(right, 1);
    right.tracked = false;
    bench.go(2);
    right.tracked = true;
    push(right, 0);
    expect(active()).toBe(1);
    push(right, 1);
    right.squeeze = 1;
    bench.go(2);
    right.squeeze = 0;
    push(right, 0);
    expect(active()).toBe(1);
  });

  it('that began as a chord means nothing more once the grip is let go', () => {
    const right = wear(VIVE, ['right']);
    right.squeeze = 1;
    bench.go(2);
    push(right, 0.8, true);
    right.squeeze = 0;
    bench.go(60);
    push(right, 0);
    expect(active()).toBe(1);
    expect(new Set(bench.acted)).toEqual(new Set(['nudgeRadius']));
  });
});

describe('with the trigger held', () => {
  it.each([QUEST, VIVE])('a push up offers the object of the stroke, and letting go takes its level: %s', (profile) => {
    const right = wear(profile, ['right']);
    bench.trigger(true);
    push(right, -0.9, true);
    push(right, 0);
    push(right, -0.9, true);
    push(right, 0);
    expect(state.object.value).toMatchObject({ completes: true, level: 1 });
    bench.go(20);
    expect(bench.edits).toHaveLength(1);
    bench.trigger(false);
    const taken = bench.sent.findLast(({ type }) => type === 'stroke_begin');
    const [stroke] = bench.sent;
    expect(taken).toMatchObject({ brush: { replaces: (stroke as { id: string }).id } });
    expect([bench.edits.length, active(), state.object.value]).toEqual([2, 1, null]);
  }); // prettier-ignore

  it('an object that was hardly seen is not taken, nor one from which one went back', () => {
    const right = wear(QUEST, ['right']);
    bench.trigger(true);
    push(right, -0.9);
    bench.trigger(false);
    push(right, 0);
    expect(bench.edits).toEqual(['stroke_begin']);
    bench.trigger(true);
    push(right, -0.9);
    push(right, 0);
    push(right, 0.9);
    push(right, 0);
    bench.go(20);
    bench.trigger(false);
    expect(bench.edits).toEqual(['stroke_begin', 'stroke_begin']);
    expect(state.object.value).toBeNull();
  });
});

it('labels are walked through as they are listed, round and round', () => {
  const palette = [3, 7, 5].map((id) => ({ id }) as Label);
  expect([3, 7, 5].map((id) => labelBeside(palette, id, 1))).toEqual([7, 5, 3]);
  expect([3, 7, 5].map((id) => labelBeside(palette, id, -1))).toEqual([5, 3, 7]);
  expect([labelBeside(palette, 3, 7), labelBeside(palette, 3, -7)]).toEqual([7, 5]);
  expect([labelBeside(palette, 0, 1), labelBeside(palette, 0, -1)]).toEqual([3, 5]);
  expect(labelBeside([], 4, 1)).toBe(4);
});
