import { beforeEach, describe, expect, it, vi } from 'vitest';
import { bindActions } from '../../store/actions';
import type { Label, Labels, Timeline } from '../../protocol/messages';
import { CELL_STATES, state } from '../../store/state';
import { finishLabel, isNew, labelActions, newLabel, takeLabels, takeTimeline } from './labels';

const pin = { id: 1, name: 'pin 1', color: '#ff5d5d', category: 'pin' } as Label;
let requests: { url: string; method: string; body: Record<string, unknown> }[] = [];
let answer: (response: Response) => void = vi.fn();

beforeEach(() => {
  bindActions(labelActions);
  vi.stubGlobal('document', { baseURI: 'http://host/' });
  requests = [];
  vi.stubGlobal('fetch', (url: string, { method, body }: RequestInit) => {
    requests.push({
      url,
      method: method!,
      body: JSON.parse(typeof body === 'string' ? body : '{}') as never,
    });
    return new Promise((resolve) => (answer = resolve));
  });
  state.palette.value = [pin];
  state.activeLabel.value = 1;
  state.notices.value = [];
  newLabel.value = null;
});

const settled = (): Promise<void> => new Promise((done) => setTimeout(done));

async function made(id: number): Promise<void> {
  const { name, color } = requests[0]!.body;
  answer(Response.json({ id, name, color, category: '' }, { status: 201 }));
  await settled();
}

describe('the timeline', () => {
  const packed = (numbers: Uint32Array | Float32Array | Uint16Array): Uint8Array =>
    new Uint8Array(numbers.buffer);
  const one = (frame: number, label: number, points: number, whole = false): Timeline => ({
    type: 'timeline',
    sequence: 'wall',
    revision: 1,
    whole,
    frames: packed(Uint32Array.of(frame)),
    labels: packed(Uint16Array.of(label)),
    points: packed(Uint32Array.of(points)),
    painted: packed(Uint32Array.of(0)),
    confidence: packed(Float32Array.of(0.75)),
    states: Uint8Array.of(CELL_STATES.indexOf('tracked')),
  });

  it('keeps the cells that a message does not name, unless it is whole', () => {
    takeTimeline(one(1, 65534, 70000, true), 3);
    takeTimeline(one(2, 65534, 4), 3);
    const { points, state: states, confidence } = state.timeline.value.rows.get(65534)!;
    expect([...points]).toEqual([0, 70000, 4]);
    expect([...states]).toEqual([0, 2, 2]);
    expect([...confidence]).toEqual([NaN, 0.75, 0.75]);
    takeTimeline(one(0, 7, 1, true), 3);
    expect([...state.timeline.value.rows.keys()]).toEqual([7]);
  });
});

describe('a new label', () => {
  it('can be named before the server has answered, and nothing is painted meanwhile', async () => {
    void labelActions.labels.newLabel();
    expect(newLabel.value).toMatchObject({ name: 'label 1', id: 0 });
    expect(requests[0]).toMatchObject({
      method: 'POST',
      body: { name: 'label 1', category: '', distinct: true },
    });
    expect(state.activeLabel.value).toBe(0);
    takeLabels({ labels: [pin], counts: {}, undo: null, redo: null } as unknown as Labels);
    expect(state.activeLabel.value).toBe(0);
    const naming = finishLabel('left pin');
    await made(2);
    answer(new Response('{}'));
    await naming;
    expect(state.activeLabel.value).toBe(2);
    expect(requests[1]).toMatchObject({ method: 'PATCH', body: { name: 'left pin' } });
  });

  it('has one row, the one with the field', async () => {
    void labelActions.labels.newLabel();
    const mine = { ...newLabel.value!, id: 2 };
    expect(isNew(newLabel.value, mine)).toBe(true);
    expect(isNew(newLabel.value, pin)).toBe(false);
    await made(2);
    expect(isNew(newLabel.value, { ...mine, name: 'renamed by another' })).toBe(true);
    void labelActions.labels.newLabel();
    expect(requests.length).toBe(1);
  });

  it('is gone again when it is given up, and when the server refuses it', async () => {
    void labelActions.labels.newLabel();
    await made(2);
    void finishLabel(null);
    await settled();
    expect(requests[1]).toMatchObject({ method: 'DELETE' });
    answer(new Response(null, { status: 204 }));

    state.activeLabel.value = 1;
    void labelActions.labels.newLabel();
    answer(Response.json({ title: 'No', detail: 'no room' }, { status: 503 }));
    await settled();
    expect([newLabel.value, state.activeLabel.value]).toEqual([null, 1]);
    expect(state.notices.value).toMatchObject([{ title: 'The label was not made' }]);
  });
});
