import { beforeEach, describe, expect, it, vi } from 'vitest';
import { Link } from './link';
import type { FromWorker, ToWorker } from './wire';

class SlowWorker {
  static last: SlowWorker;
  readonly sent: ToWorker[] = [];
  onmessage: (event: { data: FromWorker }) => void = () => undefined;

  constructor() {
    SlowWorker.last = this;
  }

  postMessage(message: ToWorker): void {
    this.sent.push(message);
  }

  says(count: number, received: number): void {
    this.onmessage({ data: { t: 'pending', count, received } });
  }
}

describe('the edits without an answer', () => {
  let pending = 0;
  let link: Link;
  beforeEach(() => {
    vi.stubGlobal('Worker', SlowWorker);
    pending = 0;
    link = new Link();
    link.listen((message) => {
      if (message.t === 'pending') pending = message.count;
    });
    return () => vi.unstubAllGlobals();
  });

  it('count from the moment they begin, before the worker has heard of them', () => {
    link.send({ type: 'undo', id: 'a' });
    expect(pending).toBe(1);
    SlowWorker.last.says(1, 1);
    expect(pending).toBe(1);
    SlowWorker.last.says(0, 1);
    expect(pending).toBe(0);
  });

  it('are not forgotten because the answer to an earlier one comes in', () => {
    link.send({ type: 'undo', id: 'a' });
    SlowWorker.last.says(1, 1);
    link.send({ type: 'stroke_end', id: 'unknown' });
    link.send({ type: 'redo', id: 'b' });
    SlowWorker.last.says(0, 1);
    expect(pending).toBe(1);
    SlowWorker.last.says(1, 2);
    expect(pending).toBe(1);
  });

  it('include what an earlier page left', () => {
    SlowWorker.last.says(2, 0);
    link.send({ type: 'undo', id: 'a' });
    expect(pending).toBe(3);
  });
});

describe('what comes while the page still loads', () => {
  it('is heard in order as soon as somebody listens', () => {
    vi.stubGlobal('Worker', SlowWorker);
    const link = new Link();
    SlowWorker.last.says(1, 0);
    SlowWorker.last.says(2, 0);
    const received: unknown[] = [];
    link.listen((message) => received.push('count' in message && message.count));
    SlowWorker.last.says(3, 0);
    expect(received).toEqual([1, 2, 3]);
    vi.unstubAllGlobals();
  });
});
