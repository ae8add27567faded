import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { SequenceInfo, ServerMessage } from '../../protocol/messages';
import { bindActions } from '../../store/actions';
import { state } from '../../store/state';
import { Inbox, type InboxDeps } from '../inbox';
import { deleteSequence, exportSequence, importSourceLabels } from './recordings';
import { recordingRow } from '../../store/testing';

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
    await exportSequence('ply');
    expect(click).not.toHaveBeenCalled();
    expect(state.notices.value).toMatchObject([
      { kind: 'error', title: 'The export did not start', detail: 'The server did not answer.' },
    ]);
  });

  it('starts where the server has the recording', async () => {
    answer(() => Promise.resolve(Response.json({ id: 'wall' })));
    await exportSequence('ply');
    expect(click).toHaveBeenCalledOnce();
    expect(state.notices.value).toMatchObject([{ kind: 'success' }]);
  });

  it('asks for the frames for validation that were chosen', async () => {
    const link = { click, href: '' };
    answer(() => Promise.resolve(Response.json({ id: 'wall' })));
    vi.stubGlobal('document', { baseURI: 'http://host/', createElement: () => link });
    await exportSequence('openpcdet', '', '3:5');
    expect(link.href).toMatch(/\/export\?format=openpcdet&val=3%3A5$/);
  });
});

describe('a recording that is deleted here', () => {
  const requests: string[] = [];
  const opened = vi.fn();
  const closeSequence = (): void => {
    state.sequence.value = null;
  };

  beforeEach(() => {
    requests.length = 0;
    bindActions({ recordings: { closeSequence, openSequence: opened } });
    vi.stubGlobal('document', { baseURI: 'http://host/' });
    vi.stubGlobal('fetch', (url: string, { method }: RequestInit) => {
      requests.push(`${method} ${new URL(url).pathname.replace('/api/v1/', '')}`);
      return Promise.resolve(
        Response.json(
          method === 'POST' ? { id: 'wall', name: 'Wall' } : method === 'GET' ? [] : {},
        ),
      );
    });
    state.sequences.value = [recordingRow('wall', 'Wall')];
  });

  it('is told once, and comes back as it was by Undo', async () => {
    await deleteSequence('wall');
    const closed = {
      type: 'error',
      title: '',
      detail: '',
      status: 404,
      about: null,
      closed: 'wall',
    };
    const inbox = new Inbox({} as InboxDeps);
    inbox.receive({ t: 'message', message: closed as ServerMessage as never });
    expect(state.sequence.value).toBe(null);
    expect(state.notices.value).toMatchObject([{ title: 'Deleted Wall' }]);
    state.notices.value[0]!.action!.run();
    await vi.waitFor(() => expect(opened).toHaveBeenCalledWith('wall'));
    expect(requests).toContain('DELETE sequences/wall');
    expect(requests).toContain('POST sequences/wall/restore');
  });
});

describe('a recording whose labels did not come in', () => {
  it('says why in the list, and is tried again', async () => {
    const requests: string[] = [];
    vi.stubGlobal('document', { baseURI: 'http://host/' });
    vi.stubGlobal('fetch', (url: string, { method }: RequestInit) => {
      requests.push(`${method} ${new URL(url).pathname.replace('/api/v1/', '')}`);
      const row = { id: 'wall', name: 'Wall', points: [4], labels_missing: 'the disk is full' };
      return Promise.resolve(
        method === 'POST'
          ? Response.json({ detail: 'the disk is full', status: 503 }, { status: 503 })
          : Response.json([row]),
      );
    });
    await importSourceLabels('wall');
    expect(requests).toEqual(['POST sequences/wall/source-labels', 'GET sequences']);
    expect(state.sequences.value).toMatchObject([{ labels_missing: 'the disk is full' }]);
    expect(state.notices.value).toMatchObject([
      { kind: 'error', title: 'The labels were not imported', detail: 'the disk is full' },
    ]);
  });
});
