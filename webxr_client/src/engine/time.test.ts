import { beforeEach, describe, expect, it, vi } from 'vitest';
import { bindActions } from '../store/actions';
import type { Label, SequenceInfo } from '../protocol/messages';
import { state } from '../store/state';
import { labelIn, showTravel } from './time';

const seek = vi.fn();
const goToObject = vi.fn();
const entry = { id: 'mine', kind: 'undo', summary: "undo: paint 'pin 1'", frames: [9, 30] };

beforeEach(() => {
  vi.clearAllMocks();
  bindActions({ time: { pause: vi.fn(), seek }, view: { goToObject } });
  vi.stubGlobal('document', { baseURI: 'http://host/' });
  vi.stubGlobal('fetch', () => Promise.resolve(Response.json([{ ...entry, id: 'other' }, entry])));
  state.sequence.value = { id: 'wall' } as SequenceInfo;
  state.palette.value = ['pin', 'pin 1'].map((name, i) => ({ id: i + 1, name }) as Label);
  state.notices.value = [];
  state.pending.value = 1;
});

describe('an undo', () => {
  it('in another frame leads there, and says so', async () => {
    state.frame.value = 12;
    showTravel('undo', 'mine');
    expect(seek).not.toHaveBeenCalled();
    state.pending.value = 0;
    await vi.waitFor(() => expect(seek).toHaveBeenCalledWith(9));
    expect(goToObject).toHaveBeenCalledWith(2, 9);
    expect(state.notices.value).toMatchObject([
      { title: 'Undone in frame 9', detail: entry.summary },
    ]);
  });

  it('that is in sight leaves one where one is', async () => {
    state.frame.value = 30;
    showTravel('undo', 'mine');
    state.pending.value = 0;
    await new Promise((done) => setTimeout(done, 20));
    expect(seek).not.toHaveBeenCalled();
  });

  it('is about the label that its words name', () => {
    expect(labelIn("paint 'pin 1'")).toBe(2);
    expect(labelIn('tracked 3 labels')).toBe(null);
  });
});
