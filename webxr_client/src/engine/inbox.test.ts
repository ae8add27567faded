import { beforeEach, describe, expect, it, vi } from 'vitest';
import { bindActions } from '../actions';
import type { Error as ErrorMessage, SequenceInfo } from '../protocol/messages';
import { state } from '../state';
import { Inbox, type InboxDeps } from './inbox';

const closed = (sequence: string): ErrorMessage => ({
  type: 'error',
  title: 'Not found',
  detail: "'Wall' was deleted",
  status: 404,
  about: null,
  closed: sequence,
});

describe('a recording that somebody deletes', () => {
  const closeSequence = vi.fn();
  const refreshSequences = vi.fn(() => Promise.resolve());
  const inbox = new Inbox({ strokes: { drop: vi.fn() } } as unknown as InboxDeps);

  beforeEach(() => {
    vi.clearAllMocks();
    bindActions({ closeSequence, refreshSequences });
    state.sequence.value = { id: 'wall' } as SequenceInfo;
    state.notices.value = [];
  });

  it('is closed, and its viewer is told and sees a new list', () => {
    inbox.receive({ t: 'message', message: closed('wall') });
    expect(closeSequence).toHaveBeenCalledOnce();
    expect(refreshSequences).toHaveBeenCalledOnce();
    expect(state.notices.value.map((notice) => notice.detail)).toEqual(["'Wall' was deleted"]);
  });

  it('leaves another one open that was opened meanwhile', () => {
    inbox.receive({ t: 'message', message: closed('other') });
    expect(closeSequence).not.toHaveBeenCalled();
    expect(refreshSequences).toHaveBeenCalledOnce();
  });
});
