import { afterEach, describe, expect, it, vi } from 'vitest';
import { PREVIEW } from '../cloud/picture/palette';
import { frameOf, wall } from '../cloud/points/testing';
import { state } from '../store/state';
import type { Ask, Brush, Candidates, ClientMessage } from '../protocol/messages';
import { numbersOf, runsOf } from '../protocol/codec';
import { ObjectTool } from './object';
import { preparation } from './preparation';
import { Strokes } from './strokes';

const brush: Brush = { label: 2, tool: 'paint', shape: 'object' };
const at = (x: number) => ({ origin: [x, 0.2, 0], direction: [0, 0, 1] }) as const;

function setUp() {
  const frame = frameOf(wall(40, 1000));
  const sent: ClientMessage[] = [];
  const send = (message: ClientMessage): void => void sent.push(structuredClone(message));
  const strokes = new Strokes({ send, seen: () => true, hidden: () => [], layers: () => [], locked: () => false, changed: vi.fn(), now: () => 0 }); // prettier-ignore
  const timers: (() => void)[] = [];
  const later = (run: () => void) => {
    timers.push(run);
    return () => void timers.splice(timers.indexOf(run), 1);
  };
  const tool = new ObjectTool({
    send,
    strokes,
    frame: () => frame,
    shift: () => [100, 0, 0],
    brush: () => brush,
    changed: vi.fn(),
    later,
  });
  const asks = () => sent.filter((message): message is Ask => message.type === 'ask');
  const begun = () => sent.flatMap((message) => (message.type === 'stroke_begin' ? [message] : []));
  const rest = () => timers.splice(0).forEach((run) => run());
  return { frame, sent, tool, asks, begun, rest };
}

function answer(ask: Ask, sizes: number[], first = 0, ready = true): Candidates {
  const candidates = sizes.map((points, level) => ({
    id: `${ask.id}-${level}`,
    level,
    score: 0.5,
    points,
    runs: new Uint8Array(Uint32Array.of(10, points).buffer),
  }));
  return { type: 'candidates', id: ask.id, frame: 0, first, ready, candidates };
}

describe('the object tool', () => {
  afterEach(() => {
    state.connection.value = { ...state.connection.value, state: 'connecting' };
    state.compiling.value = new Map();
  });

  it('says how far it is prepared, and waits until then', () => {
    const { tool } = setUp();
    state.connection.value = { ...state.connection.value, state: 'online' };
    expect([preparation(), tool.waits]).toEqual([null, false]);
    state.compiling.value = new Map([['things', 0.2]]);
    expect([preparation(), tool.waits]).toEqual([null, false]);
    state.compiling.value = new Map([['objects', 0.609]]);
    expect([preparation(), tool.waits]).toEqual(['Preparing the object tool: 60 %', true]);
  });

  it('waits for the first answer, unless the link is down', () => {
    const { tool, asks } = setUp();
    state.connection.value = { ...state.connection.value, state: 'online' };
    tool.hover(at(0.1));
    expect(tool.waits).toBe(true);
    expect(state.objectAsked.value).toBe(true);
    state.connection.value = { ...state.connection.value, state: 'offline' };
    expect(tool.waits).toBe(false);
    state.connection.value = { ...state.connection.value, state: 'online' };
    tool.onCandidates(answer(asks()[0]!, []));
    expect(state.objectAsked.value).toBe(false);
    tool.hover(at(0.3));
    expect(tool.waits).toBe(false);
  });

  it('shows what a click would take, and walks through the levels at once', () => {
    const { frame, tool, asks } = setUp();
    tool.hover(at(0.1));
    expect(asks()[0]).toMatchObject({ samples: [{ origin: [100.1, 0.2, 0] }] });
    tool.onCandidates(answer(asks()[0]!, [5, 20, 80], 1));
    expect(frame.labelOf(29)).toBe(PREVIEW);
    expect(frame.labelOf(30)).toBe(0);
    expect(state.object.value).toMatchObject({ levels: 3, level: 1, points: 20, ready: true });
    expect(tool.step(1)).toBe(true);
    expect(frame.labelOf(89)).toBe(PREVIEW);
    tool.step(9);
    expect(state.object.value?.level).toBe(2);
    expect(asks()).toHaveLength(1);
  });

  it('asks about the newest place only while an answer is on its way', () => {
    const { tool, asks } = setUp();
    for (const x of [0.1, 0.2, 0.3]) tool.hover(at(x));
    expect(asks()).toHaveLength(1);
    tool.onCandidates(answer(asks()[0]!, [5]));
    expect(asks()).toHaveLength(2);
    expect(asks()[1]!.samples[0]!.origin[0]).toBeCloseTo(100.3);
  });

  it('asks again when labels of the frame change under a still hand, at the level that was chosen', () => {
    const { tool, asks } = setUp();
    tool.hover(at(0.1));
    tool.onCandidates(answer(asks()[0]!, [5, 20, 80]));
    tool.step(1);
    tool.onLabels(7);
    expect(asks()).toHaveLength(1);
    tool.onLabels(0);
    expect(asks()[1]!.samples).toEqual(asks()[0]!.samples);
    // Labels that change while an answer is on its way may not be in it.
    tool.onLabels(0);
    tool.onCandidates(answer(asks()[1]!, [6, 21]));
    expect(state.object.value).toMatchObject({ level: 1, points: 21 });
    expect(asks()).toHaveLength(3);
    tool.onCandidates(answer(asks()[2]!, [6, 21]));
    expect(asks()).toHaveLength(3);
  });

  it('takes the level shown, and keeps it on screen until the server has it', () => {
    const { frame, tool, asks, begun, sent } = setUp();
    tool.hover(at(0.1));
    tool.onCandidates(answer(asks()[0]!, [5, 20]));
    tool.step(1);
    tool.click(at(0.1));
    expect(begun()[0]!.brush).toMatchObject({ candidate: `${asks()[0]!.id}-1`, shape: 'object' });
    expect(sent.map((message) => message.type)).toEqual(['ask', 'stroke_begin', 'stroke_samples', 'stroke_end']); // prettier-ignore
    expect(frame.labelOf(29)).toBe(2);
    expect(state.object.value).toMatchObject({ taken: true, level: 1 });
  });

  it('adds and removes by further clicks, which take the place of the first', () => {
    const { tool, asks, begun } = setUp();
    tool.hover(at(0.1));
    tool.onCandidates(answer(asks()[0]!, [5]));
    tool.click(at(0.1));
    tool.click(at(0.4));
    expect(asks()[1]).toMatchObject({ previous: `${asks()[0]!.id}-0` });
    expect(asks()[1]!.samples).toHaveLength(2);
    tool.onCandidates(answer(asks()[1]!, [9]));
    expect(begun()[1]!.brush.replaces).toBe(begun()[0]!.id);
    tool.click(at(0.2), true);
    expect(asks()[2]!.negatives).toHaveLength(1);
    tool.onCandidates(answer(asks()[2]!, [7]));
    expect(begun()[2]!.brush.replaces).toBe(begun()[1]!.id);
    tool.end();
    tool.click(at(0.1));
    tool.onCandidates(answer(asks()[3]!, [5]));
    expect(begun()[3]!.brush.replaces).toBeUndefined();
  });

  it('keeps a click that is not answered yet when another one comes', () => {
    const { tool, asks, begun } = setUp();
    tool.hover(at(0.1));
    tool.onCandidates(answer(asks()[0]!, [5]));
    for (const x of [0.1, 0.4]) tool.click(at(x));
    tool.click(at(0.2), true);
    expect(asks()[2]).toMatchObject({ samples: [{}, {}], negatives: [{}] });
    for (const ask of asks().slice(1)) tool.onCandidates(answer(ask, [7]));
    expect(begun()).toHaveLength(2);
    expect(begun()[1]!.brush.replaces).toBe(begun()[0]!.id);
  });

  it('takes another level after the click once the wheel rests', () => {
    const { tool, asks, begun, rest } = setUp();
    tool.hover(at(0.1));
    tool.onCandidates(answer(asks()[0]!, [5, 20]));
    tool.click(at(0.1));
    tool.step(1);
    expect(asks()).toHaveLength(1);
    rest();
    // The levels of the click, not the levels around the taken points.
    expect(asks()[1]).toMatchObject({ previous: '' });
    tool.onCandidates(answer(asks()[1]!, [5, 20]));
    expect(begun()[1]!.brush).toMatchObject({ candidate: `${asks()[1]!.id}-1`, previous: '', replaces: begun()[0]!.id }); // prettier-ignore
  });

  it('lays no late preview over what was taken', () => {
    const { frame, tool, asks } = setUp();
    tool.hover(at(0.1));
    tool.onCandidates(answer(asks()[0]!, [5, 20], 1));
    tool.onLabels(0);
    tool.click(at(0.1));
    tool.onCandidates(answer(asks()[1]!, [5, 20], 1));
    expect(frame.labelOf(29)).toBe(2);
  });

  it('completes a stroke, and takes its place when that is accepted', () => {
    const { tool, asks, begun } = setUp();
    tool.complete([0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6].map(at), 'the-stroke');
    expect(asks()[0]!.samples.length).toBeLessThanOrEqual(5);
    expect(tool.accept()).toBe(false);
    tool.onCandidates(answer(asks()[0]!, [5, 20], 1));
    expect(state.object.value?.completes).toBe(true);
    expect(tool.accept()).toBe(true);
    expect(begun()[0]!.brush.replaces).toBe('the-stroke');
  });

  it('asks again when the frame changed under a candidate', () => {
    const { tool, asks, begun } = setUp();
    tool.hover(at(0.1));
    tool.onCandidates(answer(asks()[0]!, [5]));
    tool.click(at(0.1));
    expect(tool.onError(begun()[0]!.id, 409)).toBe(true);
    tool.onCandidates(answer(asks()[1]!, [4]));
    expect(begun()).toHaveLength(2);
    expect(tool.onError('another', 409)).toBe(false);
  });

  it('asks again once a frame is prepared that was not', () => {
    const { tool, asks } = setUp();
    tool.hover(at(0.1));
    tool.onCandidates(answer(asks()[0]!, [5], 0, false));
    expect(state.object.value?.ready).toBe(false);
    tool.onPrepared(0);
    expect(asks()).toHaveLength(2);
  });

  it('offers the smallest level of a frame that is not prepared', () => {
    const { tool, asks } = setUp();
    tool.hover(at(0.1));
    tool.onCandidates(answer(asks()[0]!, [5, 20, 80], 2, false));
    expect(state.object.value).toMatchObject({ level: 0, points: 5, ready: false });
  });

  it('does not change what is lit under a still hand when the frame is prepared', () => {
    const { tool, asks } = setUp();
    tool.hover(at(0.1));
    tool.onCandidates(answer(asks()[0]!, [5, 20, 80], 0, false));
    tool.step(1);
    tool.onPrepared(0);
    tool.onCandidates(answer(asks()[1]!, [2, 5, 22, 90], 3));
    expect(state.object.value).toMatchObject({ level: 2, points: 22, ready: true });
    // The level that the wheel has chosen stays on the same object, and is not that of another.
    tool.hover(at(0.2));
    tool.onCandidates(answer(asks()[2]!, [3, 21, 90], 0));
    expect(state.object.value).toMatchObject({ level: 1, points: 21 });
    tool.hover(at(0.3));
    tool.onCandidates(answer(asks()[3]!, [200, 900], 0));
    expect(state.object.value).toMatchObject({ level: 0, points: 200 });
  });

  it('lights what another level would take after the click, whatever the label’s colour', () => {
    const { frame, tool, asks } = setUp();
    tool.hover(at(0.1));
    tool.onCandidates(answer(asks()[0]!, [5, 20]));
    tool.click(at(0.1));
    tool.step(1);
    expect(frame.labelOf(29)).toBe(PREVIEW);
  });

  it('says that a frame is prepared while what was taken before stays', () => {
    const { tool, asks } = setUp();
    tool.hover(at(0.1));
    tool.onCandidates(answer(asks()[0]!, [5], 0, false));
    tool.click(at(0.1));
    expect(state.object.value).toMatchObject({ taken: true, ready: false });
    tool.onPrepared(0);
    expect(state.object.value).toMatchObject({ taken: true, ready: true, points: 5 });
    expect(asks()).toHaveLength(1);
  });

  it('leaves nothing on screen when the pointer leaves', () => {
    const { frame, tool, asks } = setUp();
    tool.hover(at(0.1));
    tool.onCandidates(answer(asks()[0]!, [5]));
    tool.leave();
    expect(frame.overlays.size).toBe(0);
    expect(state.object.value).toBeNull();
  });
});

it('reads runs of numbers', () => {
  const runs = new Uint8Array(Uint32Array.of(3, 2, 9, 1).buffer);
  expect([...numbersOf(runs)]).toEqual([3, 4, 9]);
  expect(runsOf(Uint32Array.of(3, 4, 4, 9))).toEqual(runs);
});
