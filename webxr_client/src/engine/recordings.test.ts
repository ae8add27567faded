import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { SequenceInfo } from '../protocol/messages';
import { state } from '../state';
import { recordingActions } from './recordings';

const click = vi.fn();

function answer(fetched: () => Promise<Response>): void {
  vi.stubGlobal('document', { baseURI: 'http://host/', createElement: () => ({ click }) });
  vi.stubGlobal('fetch', vi.fn(fetched));
}

beforeEach(() => {
  state.sequence.value = { id: 'wall' } as SequenceInfo;
  state.notices.value = [];
});
afterEach(() => {
  vi.unstubAllGlobals();
  vi.clearAllMocks();
});

describe('an export', () => {
  it('says that there is no server instead of that it started', async () => {
    answer(() => Promise.reject(new TypeError('Failed to fetch')));
    await recordingActions.exportSequence('ply');
    expect(click).not.toHaveBeenCalled();
    expect(state.notices.value).toMatchObject([
      { kind: 'error', title: 'The export did not start', detail: 'The server did not answer.' },
    ]);
  });

  it('starts where the server has the recording', async () => {
    answer(() => Promise.resolve(Response.json({ id: 'wall' })));
    await recordingActions.exportSequence('ply');
    expect(click).toHaveBeenCalledOnce();
    expect(state.notices.value).toMatchObject([{ kind: 'success' }]);
  });
});
