import { beforeEach, describe, expect, it } from 'vitest';
import { decode, encode } from '../protocol/codec';
import type { ClientMessage, SequenceInfo } from '../protocol/messages';
import { Backoff } from './backoff';
import { Session, type Outside, type Socket, type SocketHandlers } from './session';
import { MemoryStorage } from './storage';
import type { ToDecoder } from './wire';

class Wire implements Socket {
  bufferedAmount = 0;
  readonly sent: ClientMessage[] = [];

  constructor(private readonly handlers: SocketHandlers) {}

  opens(): void {
    this.handlers.opened(this);
  }

  closes(code: number): void {
    this.handlers.closed(this, { code, reason: '' });
  }

  send(data: Uint8Array<ArrayBuffer>): void {
    this.sent.push(decode(data.slice().buffer) as unknown as ClientMessage);
  }

  says(message: object): void {
    this.handlers.received(encode(message as never).slice().buffer);
  }

  get types(): string[] {
    return this.sent.map((message) => message.type);
  }
}

class Browser implements Outside {
  readonly depth = true;
  readonly sockets: Wire[] = [];
  readonly posted: ToDecoder[] = [];
  refusal = '';
  later: (() => void) | null = null;

  dial(handlers: SocketHandlers): Socket {
    this.sockets.push(new Wire(handlers));
    return this.wire;
  }

  get wire(): Wire {
    return this.sockets.at(-1)!;
  }

  whyRefused(): Promise<string> {
    return Promise.resolve(this.refusal);
  }

  post(message: ToDecoder): void {
    this.posted.push(message);
  }

  after(_: number, act: () => void): () => void {
    this.later = act;
    return () => (this.later = null);
  }

  /** States of the link that were sent to the page, oldest first. */
  get links(): string[] {
    return this.posted.flatMap((message) => (message.t === 'link' ? [message.state] : []));
  }

  get unanswered(): number | undefined {
    return this.posted
      .flatMap((message) => (message.t === 'pending' ? [message.count] : []))
      .at(-1);
  }
}

const OPEN = { type: 'open', sequence: 's', frame: 0 } as ClientMessage & { type: 'open' };

function answer(identity: string, revision: number): SequenceInfo {
  return { type: 'sequence', id: 's', identity, revision } as SequenceInfo;
}

function labels(revision: number, base: number | null, edit: string | null = null): object {
  const none = new Uint8Array();
  return {
    ...{ type: 'annotation', sequence: 's', frame: 0, revision, base, edit },
    ...{ provisional: false, first: 0, count: 0, lengths: none, values: none },
  };
}

describe('a session', () => {
  let browser: Browser;
  let session: Session;
  beforeEach(async () => {
    browser = new Browser();
    session = new Session(browser, new Backoff(() => 0.5));
    await session.restore(new MemoryStorage());
  });

  /** Connect and have the recording answered. */
  function live(identity = 'one', revision = 7): Wire {
    session.connect();
    session.open(OPEN);
    browser.wire.opens();
    browser.wire.says(answer(identity, revision));
    return browser.wire;
  }

  async function dropped(code = 1006): Promise<void> {
    browser.wire.closes(code);
    await Promise.resolve();
    await Promise.resolve();
  }

  it('greets, opens what the page asked for meanwhile, and connects once', () => {
    session.connect();
    session.open(OPEN);
    session.connect();
    browser.wire.opens();
    expect(browser.sockets).toHaveLength(1);
    expect(browser.wire.types).toEqual(['hello', 'open']);
    expect(browser.links).toEqual(['connecting', 'online']);
  });

  it('holds edits back until the recording is answered, and those of a lost link until then', async () => {
    const first = live();
    session.send({ type: 'undo', id: 'a' });
    expect(first.types).toEqual(['hello', 'open', 'undo']);
    await dropped();
    session.send({ type: 'redo', id: 'b' });
    expect(browser.links.at(-1)).toBe('offline');
    expect(browser.unanswered).toBe(2);
    browser.later?.();
    browser.wire.opens();
    expect(browser.wire.types).toEqual(['hello', 'open']);
    browser.wire.says(answer('one', 8));
    expect(browser.wire.types).toEqual(['hello', 'open', 'undo', 'redo']);
  });

  it('resumes one revision back', async () => {
    live('one', 7);
    await dropped();
    browser.later?.();
    browser.wire.opens();
    expect(browser.wire.sent[1]).toMatchObject({ identity: 'one', revision: 6 });
  });

  it('starts anew where the server knows no such revision', async () => {
    live('one', 7);
    await dropped();
    browser.later?.();
    browser.wire.opens();
    browser.wire.says({ type: 'error', about: null, status: 409, title: '', detail: '' });
    expect(browser.wire.sent.at(-1)).toMatchObject({ type: 'open', revision: null });
  });

  it('drops edits of a recording that another one was imported in place of', async () => {
    live('one');
    session.send({ type: 'undo', id: 'a' });
    await dropped();
    browser.later?.();
    browser.wire.opens();
    browser.wire.says(answer('two', 0));
    expect(browser.unanswered).toBe(0);
    expect(browser.wire.types).toEqual(['hello', 'open']);
  });

  it('asks again for what is missing before a change that does not join on', () => {
    const wire = live('one', 7);
    wire.says(labels(7, null));
    wire.says(labels(9, 8, 'a'));
    expect(wire.sent.at(-1)).toMatchObject({ type: 'open', revision: 6 });
  });

  it('takes an edit as answered when its change comes', () => {
    const wire = live('one', 7);
    wire.says(labels(7, null));
    session.send({ type: 'undo', id: 'a' });
    wire.says(labels(8, 7, 'a'));
    expect(browser.unanswered).toBe(0);
  });

  it('gives up where it is refused, and says why', async () => {
    browser.refusal = 'no token';
    session.connect();
    await dropped();
    expect(browser.posted.at(-1)).toMatchObject({ state: 'refused', detail: 'no token' });
    expect(browser.later).toBeNull();
  });

  it('gives up where a token is revoked, and keeps what was painted', async () => {
    live();
    const brush = { label: 1, tool: 'paint', shape: 'ray', radius: 0.05 } as const;
    session.send({ type: 'stroke_begin', id: 'a', frame: 3, brush });
    await dropped(4401);
    expect(browser.posted.at(-1)).toMatchObject({
      state: 'refused',
      unsent: [{ frame: 3, tool: 'paint', label: 1 }],
    });
  });

  it('connects at once when the browser is online again, and not a second time', async () => {
    live();
    await dropped();
    session.connect();
    expect(browser.later).toBeNull();
    expect(browser.sockets).toHaveLength(2);
  });

  it('holds credits back while the page lags behind', () => {
    const wire = live();
    for (let i = 0; i < 8; i += 1) session.decoded({ nbytes: 10, decodeMs: 1 });
    const credits = (): number => wire.types.filter((type) => type === 'credit').length;
    expect(credits()).toBe(6);
    session.applied({ points: 5 });
    expect(credits()).toBe(7);
    expect(wire.sent.at(-1)).toMatchObject({ points: 5 });
  });
});

it('keeps what the page does until the edits of an earlier one are known', async () => {
  const browser = new Browser();
  const session = new Session(browser);
  session.connect();
  session.open(OPEN);
  browser.wire.opens();
  browser.wire.says(answer('one', 1));
  session.send({ type: 'undo', id: 'a' });
  expect(browser.wire.types).toEqual(['hello', 'open']);
  await session.restore(new MemoryStorage());
  expect(browser.wire.types).toEqual(['hello', 'open', 'undo']);
});
