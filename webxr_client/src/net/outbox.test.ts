import { describe, expect, it } from 'vitest';
import type { Brush } from '../protocol/messages';
import { Backoff } from './backoff';
import { Outbox, type OutboxEntry, type OutboxStorage } from './outbox';

class Disk implements OutboxStorage {
  readonly kept = new Map<string, OutboxEntry>();
  load(): Promise<OutboxEntry[]> {
    return Promise.resolve([...this.kept.values()].map((entry) => structuredClone(entry)));
  }
  put(entry: OutboxEntry): void {
    this.kept.set(entry.id, structuredClone(entry));
  }
  remove(id: string): void {
    this.kept.delete(id);
  }
}

const brush: Brush = { label: 1, tool: 'paint', shape: 'ray', radius: 0.05 };

function stroke(outbox: Outbox, id: string, recording = 's'): void {
  outbox.note(recording, { type: 'stroke_begin', id, frame: 0, brush });
  outbox.note(recording, { type: 'stroke_samples', id, samples: [{ origin: [0, 0, 0] }] });
  outbox.note(recording, { type: 'stroke_samples', id, samples: [{ origin: [1, 0, 0] }] });
  outbox.note(recording, { type: 'stroke_end', id });
}

describe('the outbox', () => {
  it('sends unanswered edits again, whole and in order', () => {
    const outbox = new Outbox(new Disk(), () => 5);
    stroke(outbox, 'a');
    outbox.note('s', { type: 'undo', id: 'b' });
    stroke(outbox, 'c');
    outbox.settle('a');
    const resent = outbox.resend('s');
    expect(resent.map((message) => message.type)).toEqual([
      'undo',
      'stroke_begin',
      'stroke_samples',
      'stroke_end',
    ]);
    expect(resent[2]).toMatchObject({ samples: [{ origin: [0, 0, 0] }, { origin: [1, 0, 0] }] });
  });

  it('names the strokes that it keeps, as one would say them', () => {
    const outbox = new Outbox(new Disk());
    stroke(outbox, 'a');
    outbox.note('s', { type: 'undo', id: 'b' });
    const erasing: Brush = { ...brush, tool: 'erase' };
    outbox.note('s', { type: 'stroke_begin', id: 'c', frame: 4, brush: erasing });
    expect(outbox.strokes()).toEqual([
      { frame: 0, tool: 'paint', label: 1 },
      { frame: 4, tool: 'erase', label: 0 },
    ]);
  });

  it('keeps what belongs to another recording for when that is open', () => {
    const outbox = new Outbox(new Disk());
    stroke(outbox, 'a', 'other');
    expect(outbox.resend('s')).toEqual([]);
    expect(outbox.size).toBe(1);
  });

  it('gives up the edits of a recording that is gone', () => {
    const outbox = new Outbox(new Disk());
    stroke(outbox, 'a');
    stroke(outbox, 'b', 'other');
    expect(outbox.abandon('s')).toBe(true);
    expect(outbox.abandon('s')).toBe(false);
    expect(outbox.resend('s')).toEqual([]);
    expect(outbox.resend('other')).toHaveLength(3);
  });

  it('survives a closed page', async () => {
    const disk = new Disk();
    stroke(new Outbox(disk), 'a');
    const next = new Outbox(disk);
    await next.restore();
    expect(next.resend('s')).toHaveLength(3);
    expect(next.settle('a')).toBe(true);
    expect(next.settle('a')).toBe(false);
    expect(disk.kept.size).toBe(0);
  });

  it('ends a stroke that was cut off, but not one that another tab may be drawing', async () => {
    const disk = new Disk();
    const first = new Outbox(disk, () => 1000);
    first.note('s', { type: 'stroke_begin', id: 'a', frame: 0, brush });
    const soon = new Outbox(disk, () => 2000);
    await soon.restore();
    expect(soon.size).toBe(0);
    const later = new Outbox(disk, () => 60_000);
    await later.restore();
    expect(later.resend('s').at(-1)).toMatchObject({ type: 'stroke_end', id: 'a' });
  });

  it('takes a tracking job for the answer to the request', () => {
    const outbox = new Outbox(new Disk());
    outbox.note('s', { type: 'track', id: 't', start: 0, stop: 5 });
    stroke(outbox, 'a');
    expect(outbox.settleTracks()).toEqual(['t']);
    expect(outbox.size).toBe(1);
  });
});

describe('the backoff', () => {
  it('doubles up to a limit and starts over', () => {
    const backoff = new Backoff(() => 0.5);
    const waits = Array.from({ length: 8 }, () => backoff.next());
    expect(waits).toEqual([250, 500, 1000, 2000, 4000, 8000, 8000, 8000]);
    backoff.reset();
    expect(backoff.next()).toBe(250);
  });
});
