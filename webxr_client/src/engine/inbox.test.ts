import { beforeEach, describe, expect, it, vi } from 'vitest';
import { bindActions } from '../store/actions';
import type {
  Compiling,
  Error as ErrorMessage,
  Job,
  SequenceInfo,
  Welcome,
} from '../protocol/messages';
import {
  canCancel,
  canEdit,
  canManage,
  CELL_STATES,
  state,
  trackingJob,
  type SequenceSummary,
  type TimelineRow,
} from '../store/state';
import { refusal } from '../tools/brush';
import { Inbox, type InboxDeps } from './inbox';
import { startRun } from './review';

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
    bindActions({ recordings: { closeSequence, refreshSequences } });
    state.sequence.value = { id: 'wall' } as SequenceInfo;
    state.sequences.value = [{ id: 'wall' } as SequenceSummary];
    state.notices.value = [];
  });

  it('is closed, and its viewer is told and sees a new list', () => {
    inbox.receive({ t: 'message', message: closed('wall') });
    expect(closeSequence).toHaveBeenCalledOnce();
    expect(state.sequences.value).toEqual([]);
    expect(refreshSequences).toHaveBeenCalledOnce();
    expect(state.notices.value.map((notice) => notice.detail)).toEqual(["'Wall' was deleted"]);
  });

  it('leaves another one open that was opened meanwhile', () => {
    inbox.receive({ t: 'message', message: closed('other') });
    expect(closeSequence).not.toHaveBeenCalled();
    expect(refreshSequences).toHaveBeenCalledOnce();
  });
});

describe('loops that the server compiles', () => {
  it('are known until they are done, or another server answers', () => {
    const deps = { objects: { restart: vi.fn() }, regions: { leave: vi.fn() } };
    const following = { clear: vi.fn() };
    const inbox = new Inbox({
      ...deps,
      following,
      opening: new Promise(() => {}),
    } as unknown as InboxDeps);
    const on = (step: Compiling['step'], share: number): void =>
      inbox.receive({ t: 'message', message: { type: 'compiling', step, share, seconds: null } });
    on('objects', 0.5);
    on('things', 0);
    expect([...state.compiling.value]).toEqual([
      ['objects', 0.5],
      ['things', 0],
    ]);
    on('objects', 1);
    expect([...state.compiling.value.keys()]).toEqual(['things']);
    inbox.receive({ t: 'message', message: { type: 'welcome' } as Welcome });
    expect(state.compiling.value.size).toBe(0);
  });
});

describe('the end of a run', () => {
  const openSequence = vi.fn();
  const job: Job = {
    type: 'job',
    id: 'run',
    kind: 'tracking',
    sequence: 'wall',
    state: 'done',
    progress: 1,
    message: 'pin: 2 frames, 1 doubtful',
    frame: null,
    error: null,
    edit: 'edit',
    owner: 'ada',
  };
  const deps = { following: { job: vi.fn() }, viewer: { invalidate: vi.fn() } };
  const inbox = new Inbox(deps as unknown as InboxDeps);
  const titles = (): string[] => state.notices.value.map((notice) => notice.title);
  const row: TimelineRow = {
    points: Uint32Array.of(9, 9, 9),
    painted: Uint32Array.of(9, 0, 0),
    confidence: Float32Array.of(1, 0.9, 0.2),
    state: Uint8Array.of(0, 2, 2),
  };

  beforeEach(() => {
    bindActions({ time: { pause: vi.fn(), seek: vi.fn() }, labels: { selectLabel: vi.fn() } });
    state.sequence.value = { id: 'wall' } as SequenceInfo;
    state.notices.value = [];
    state.jobs.value = [];
    state.timeline.value = { rows: new Map() };
    expect(CELL_STATES[2]).toBe('tracked');
  });

  it('is told once, in the words of its counts', () => {
    inbox.receive({ t: 'message', message: job });
    inbox.receive({ t: 'message', message: job });
    expect(state.notices.value).toMatchObject([{ title: 'Tracked', detail: job.message }]);
  });

  it('is told once where it failed, too, until it is dismissed', () => {
    inbox.receive({ t: 'message', message: { ...job, state: 'failed', error: 'no room' } });
    expect(state.notices.value).toMatchObject([{ kind: 'error', detail: 'no room' }]);
  });

  it('is not told where somebody else’s ended in another recording', () => {
    state.me.value = {
      viewer: 'v',
      author: 'Ada',
      account: 'ada',
      role: 'annotator',
      serverVersion: '',
    };
    inbox.receive({ t: 'message', message: { ...job, owner: 'bob', sequence: 'street' } });
    expect(state.notices.value).toEqual([]);
    // The user cannot stop it, and it does not block the user's own run.
    const running = { ...job, owner: 'bob', sequence: 'street', state: 'running' } as const;
    inbox.receive({ t: 'message', message: running });
    expect([trackingJob.value, canCancel(running), canCancel(job)]).toEqual([null, false, true]);
    state.me.value = { ...state.me.value, role: 'manager' };
    expect(canCancel(running)).toBe(true);
    state.me.value = { ...state.me.value, role: 'viewer' };
    expect(canCancel(job)).toBe(false);
    state.me.value = null;
  });

  it('of an import offers to open it until that is used', async () => {
    bindActions({ recordings: { refreshSequences: () => Promise.resolve(), openSequence } });
    vi.useFakeTimers();
    inbox.receive({ t: 'message', message: { ...job, kind: 'import', sequence: 'street' } });
    await vi.advanceTimersByTimeAsync(60_000);
    vi.useRealTimers();
    expect(state.notices.value).toMatchObject([{ title: 'Imported', action: { label: 'Open' } }]);
    state.notices.value[0]!.action!.run();
    expect(openSequence).toHaveBeenCalledWith('street');
  });

  it('is told by its doubt where it stopped for one', async () => {
    const how = { method: 'auto', overwrite: 'tracked', stop_unsure: true } as const;
    startRun({ labels: [1], start: 0, stop: 2, ...how });
    inbox.receive({ t: 'message', message: job });
    expect(titles()).toEqual(['Tracked']);
    state.timeline.value = { rows: new Map([[1, row]]) };
    await Promise.resolve();
    expect(titles()).toEqual(['Doubtful here: A label']);
  });
});

describe('a page that the server refuses', () => {
  it('has no tools, and says which strokes wait', () => {
    const inbox = new Inbox({} as InboxDeps);
    const unsent = [{ frame: 3, tool: 'paint', label: 1 }];
    const link = { t: 'link', detail: 'revoked', retryMs: null } as const;
    inbox.receive({ ...link, state: 'refused', unsent });
    expect([canEdit.value, canManage.value]).toEqual([false, false]);
    expect(refusal()?.[0]).toBe('The server refused this page');
    expect(state.connection.value.unsent).toEqual(unsent);
    inbox.receive({ ...link, state: 'online', unsent: [] });
    expect(canEdit.value).toBe(true);
  });
});
