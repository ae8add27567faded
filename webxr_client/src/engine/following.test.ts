import { beforeEach, describe, expect, it } from 'vitest';
import type { Job, StrokeResult, Track } from '../protocol/messages';
import { Following } from './following';

let requests: Track[];
let cancelled: string[];
let busy: boolean;
let timers: (() => void)[];
let following: Following;

beforeEach(() => {
  requests = [];
  cancelled = [];
  busy = false;
  timers = [];
  following = new Following({
    send: (message) => void requests.push(message),
    cancel: (job) => void cancelled.push(job),
    on: () => true,
    busy: () => busy,
    last: () => 9,
    later: (run) => {
      timers.push(run);
      return () => void timers.splice(timers.indexOf(run), 1);
    },
  });
});

const wait = (): void => timers.splice(0).forEach((run) => run());
const paint = (stroke: string, label: number, frame = 3): void => {
  following.begin(stroke, { tool: 'paint', label });
  following.result({ id: stroke, frame, final: true, changed: 5 } as StrokeResult);
};
const job = (state: Job['state'], edit = requests.at(-1)!.id): void =>
  following.job({ id: `job-${edit}`, edit, state, kind: 'tracking' } as Job);

describe('following', () => {
  it('carries a label on to its next painted frame, once its stroke has settled', () => {
    paint('a', 2);
    expect(requests).toHaveLength(0);
    wait();
    expect(requests[0]).toMatchObject({ labels: [2], start: 3, stop: 9, until_painted: true });
  });

  it('yields to strokes and jobs, and does one label at a time', () => {
    paint('a', 2);
    paint('b', 3);
    busy = true;
    wait();
    expect(requests).toHaveLength(0);
    busy = false;
    wait();
    wait();
    expect(requests.map((track) => track.labels)).toEqual([[2]]);
    job('done');
    wait();
    expect(requests.map((track) => track.labels)).toEqual([[2], [3]]);
  });

  it('is stopped by the next stroke on the label, also before its job is known', () => {
    paint('a', 2);
    wait();
    job('running');
    following.begin('b', { tool: 'paint', label: 2 });
    expect(cancelled).toEqual([`job-${requests[0]!.id}`]);
    following.result({ id: 'b', frame: 3, final: true, changed: 1 } as StrokeResult);
    wait();
    following.begin('c', { tool: 'paint', label: 2 });
    job('queued');
    expect(cancelled).toEqual(requests.map((track) => `job-${track.id}`));
  });

  it('goes with its stroke in one undo, until something else is painted', () => {
    paint('a', 2);
    wait();
    job('done');
    expect(following.undo()).toBe(2);
    expect(following.undo()).toBe(1);
    paint('b', 2);
    wait();
    job('done');
    following.begin('c', { tool: 'erase' });
    expect(following.undo()).toBe(1);
  });

  it('does nothing in the last frame, when nothing changed', () => {
    paint('a', 2, 9);
    following.begin('b', { tool: 'paint', label: 3 });
    following.result({ id: 'b', frame: 0, final: true, changed: 0 } as StrokeResult);
    following.begin('c', { tool: 'erase' });
    following.result({ id: 'c', frame: 0, final: true, changed: 4 } as StrokeResult);
    wait();
    expect(requests).toHaveLength(0);
  });
});
