import { beforeEach, describe, expect, it, vi } from 'vitest';
import { bindActions } from '../store/actions';
import type { Label, Labels } from '../protocol/messages';
import { state } from '../store/state';
import { finishLabel, isNew, labelActions, newLabel, takeLabels } from './labels';

const pin = { id: 1, name: 'pin 1', color: '#ff5d5d', category: 'pin' } as Label;
let asked: { url: string; method: string; body: Record<string, unknown> }[] = [];
let answer: (response: Response) => void = vi.fn();

beforeEach(() => {
  bindActions(labelActions);
  vi.stubGlobal('document', { baseURI: 'http://host/' });
  asked = [];
  vi.stubGlobal('fetch', (url: string, { method, body }: RequestInit) => {
    asked.push({
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
  const { name, color } = asked[0]!.body;
  answer(Response.json({ id, name, color, category: '' }, { status: 201 }));
  await settled();
}

describe('a new label', () => {
  it('can be named before the server has answered, and nothing is painted meanwhile', async () => {
    void labelActions.newLabel();
    expect(newLabel.value).toMatchObject({ name: 'label 1', id: 0 });
    expect(asked[0]).toMatchObject({
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
    expect(asked[1]).toMatchObject({ method: 'PATCH', body: { name: 'left pin' } });
  });

  it('has one row, the one with the field', async () => {
    void labelActions.newLabel();
    const mine = { ...newLabel.value!, id: 2 };
    expect(isNew(newLabel.value, mine)).toBe(true);
    expect(isNew(newLabel.value, pin)).toBe(false);
    await made(2);
    expect(isNew(newLabel.value, { ...mine, name: 'renamed by another' })).toBe(true);
    void labelActions.newLabel();
    expect(asked.length).toBe(1);
  });

  it('is gone again when it is given up, and when the server refuses it', async () => {
    void labelActions.newLabel();
    await made(2);
    void finishLabel(null);
    await settled();
    expect(asked[1]).toMatchObject({ method: 'DELETE' });
    answer(new Response(null, { status: 204 }));

    state.activeLabel.value = 1;
    void labelActions.newLabel();
    answer(Response.json({ title: 'No', detail: 'no room' }, { status: 503 }));
    await settled();
    expect([newLabel.value, state.activeLabel.value]).toEqual([null, 1]);
    expect(state.notices.value).toMatchObject([{ title: 'The label was not made' }]);
  });
});
