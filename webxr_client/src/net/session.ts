/**
 * The page's session with the server: the link, the recording that is open, and edits on their way.
 * It survives any number of sockets.  `Outside` has the functions of the browser.
 */
import { decode, encode, unpackU16, unpackU32 } from '../protocol/codec';
import type {
  Annotation,
  ClientMessage,
  Open,
  SequenceInfo,
  ServerMessage,
} from '../protocol/messages';
import { Backoff } from './backoff';
import { Credits } from './credits';
import { HeldFrames } from './held';
import { begins, isEdit, Outbox, type OutboxStorage } from './outbox';
import { labelBuffers } from './pairing';
import { MemoryStorage } from './storage';
import type { Decoded, LinkState, Pace, ToDecoder } from './wire';

/** Unsent bytes above which the link counts as stalled and droppable messages are dropped. */
const SEND_LIMIT = 1 << 20;
const UNAUTHORIZED = 401;
/** Close codes after which trying again cannot help. */
const REFUSALS = new Set([4401, 4403, 1008]);

/** One connection to the server, as a `WebSocket` is. */
export interface Socket {
  readonly bufferedAmount: number;
  send(data: Uint8Array<ArrayBuffer>): void;
}

/** Events of a connection; `closed` comes last, also where it never opened. */
export interface SocketHandlers {
  opened(socket: Socket): void;
  received(data: ArrayBuffer): void;
  closed(socket: Socket, event: Closing): void;
}

export interface Closing {
  readonly code: number;
  readonly reason: string;
}

export interface Outside {
  /** Whether depth images can be decoded here; without it all frames come as points. */
  readonly depth: boolean;
  /** Begin to connect. */
  dial(handlers: SocketHandlers): Socket;
  /** Message with the reason why the server refuses a socket; empty if it does not. */
  whyRefused(): Promise<string>;
  post(message: ToDecoder, transfer?: Transferable[]): void;
  /** Call later; the result cancels it. */
  after(ms: number, act: () => void): () => void;
}

type Connection =
  | { readonly state: 'idle' }
  | { readonly state: 'connecting' | 'online'; readonly socket: Socket }
  /** `stop` cancels the automatic reconnect. */
  | { readonly state: 'offline'; readonly stop: () => void }
  /** The socket is closed, and a request asks for the reason. */
  | { readonly state: 'asking' }
  | { readonly state: 'refused' };

type Recording =
  | { readonly state: 'closed' }
  /**
   * Requested on this socket or on the next one.  From an earlier answer: the import's
   * `identity`, and the newest revision that the page has received.
   */
  | {
      readonly state: 'asked';
      readonly open: Open;
      readonly identity: string | null;
      readonly revision: number | null;
    }
  /** The server has answered: edits may go out. */
  | {
      readonly state: 'live';
      readonly open: Open;
      readonly identity: string;
      readonly revision: number;
    };

export class Session {
  private connection: Connection = { state: 'idle' };
  private recording: Recording = { state: 'closed' };
  private readonly held = new HeldFrames();
  private readonly credits = new Credits();
  private outbox = new Outbox(new MemoryStorage());
  /** Messages that wait until the edits that an earlier page left are known; null once they are. */
  private queue: (() => void)[] | null = [];
  /** Edits that the page has begun. */
  private received = 0;

  constructor(
    private readonly outside: Outside,
    private readonly backoff = new Backoff(),
  ) {}

  /** Take up the edits that an earlier page left in `storage`. */
  async restore(storage: OutboxStorage): Promise<void> {
    this.outbox = new Outbox(storage);
    await this.outbox.restore();
    const queue = this.queue ?? [];
    this.queue = null;
    this.report();
    for (const act of queue) act();
  }

  /** Now, or in its turn once the edits that an earlier page left are known. */
  private onceRestored(act: () => void): void {
    if (this.queue) this.queue.push(act);
    else act();
  }

  /** Connect, unless there is a connection or one on its way. */
  connect(): void {
    const { connection } = this;
    if (connection.state === 'connecting' || connection.state === 'online') return;
    if (connection.state === 'offline') connection.stop();
    this.link('connecting');
    const socket = this.outside.dial({
      opened: (opened) => this.welcomed(opened),
      received: (data) => this.onceRestored(() => this.receive(data)),
      closed: (closed, event) => void this.lost(closed, event),
    });
    this.connection = { state: 'connecting', socket };
  }

  private welcomed(socket: Socket): void {
    this.connection = { state: 'online', socket };
    this.credits.reset();
    this.backoff.reset();
    this.link('online');
    this.transmit({ type: 'hello', depth: this.outside.depth });
    this.reopen();
  }

  private async lost(socket: Socket, event: Closing): Promise<void> {
    const before = this.connection;
    if (!('socket' in before) || before.socket !== socket) return;
    this.unanswered();
    // A browser does not report why a socket was refused; a plain request returns the reason.
    const asking: Connection = { state: 'asking' };
    this.connection = asking;
    const refusal = before.state === 'online' ? refusalOf(event) : await this.outside.whyRefused();
    if (this.connection !== asking) return;
    if (refusal) {
      this.connection = { state: 'refused' };
      this.link('refused', refusal);
      return;
    }
    const wait = this.backoff.next();
    this.connection = { state: 'offline', stop: this.outside.after(wait, () => this.connect()) };
    this.link('offline', event.reason, wait);
  }

  /** Open a recording in place of the one before it. */
  open(open: Open): void {
    this.recording = { state: 'asked', open, identity: null, revision: null };
    this.held.clear();
    this.transmit(open);
  }

  close(): void {
    this.recording = { state: 'closed' };
  }

  send(message: ClientMessage): void {
    this.onceRestored(() => this.sendNow(message));
  }

  private sendNow(message: ClientMessage): void {
    const live = this.recording.state === 'live';
    if (message.type === 'stroke_cancel') {
      this.outbox.settle(message.id);
      this.report();
      if (!live) return;
    }
    if (isEdit(message)) {
      if (begins(message)) this.received += 1;
      const { identity } = this;
      if (identity !== null) this.outbox.note(identity, message);
      this.report();
      if (!live) return;
    }
    if (message.type === 'forget') {
      this.held.forget(message.frames);
      this.outside.post({ t: 'forget', frames: message.frames });
    }
    this.transmit(message);
  }

  decoded(frame: Decoded): void {
    this.onceRestored(() => this.transmitIf(this.credits.decoded(frame)));
  }

  applied(pace: Pace): void {
    this.onceRestored(() => this.transmitIf(this.credits.applied(pace)));
  }

  paced(pace: Pace): void {
    this.onceRestored(() => this.transmit(this.credits.paced(pace)));
  }

  /** Send the page the number of edits without an answer. */
  private report(): void {
    this.outside.post({ t: 'pending', count: this.outbox.size, received: this.received });
  }

  private get identity(): string | null {
    return this.recording.state === 'closed' ? null : this.recording.identity;
  }

  private shows(sequence: string): boolean {
    return this.recording.state !== 'closed' && this.recording.open.sequence === sequence;
  }

  private link(state: LinkState, detail = '', retryMs: number | null = null): void {
    const unsent = state === 'refused' ? this.outbox.strokes() : [];
    this.outside.post({ t: 'link', state, detail, retryMs, unsent });
  }

  /** The answer to `open` is no longer true of the socket, or of the next one. */
  private unanswered(): void {
    if (this.recording.state === 'live') this.recording = { ...this.recording, state: 'asked' };
  }

  /** Open the recording again, to receive the changes since the last answer. */
  private reopen(): void {
    this.unanswered();
    if (this.recording.state !== 'asked') return;
    const { open, identity, revision } = this.recording;
    // One back: of the newest edit perhaps not every frame's part has come.
    const since = revision === null ? null : Math.max(0, revision - 1);
    if (since === null) this.transmit(open);
    else this.transmit({ ...open, identity, revision: since, held: this.held.list() });
  }

  private transmit(message: ClientMessage): void {
    if (this.connection.state !== 'online') return;
    const { socket } = this.connection;
    // Poses of a person's hands matter only now.
    if (message.type === 'presence' && socket.bufferedAmount > SEND_LIMIT) return;
    socket.send(encode(message));
  }

  private transmitIf(message: ClientMessage | null): void {
    if (message) this.transmit(message);
  }

  private settle(id: string): void {
    if (this.outbox.settle(id)) this.report();
  }

  private receive(data: ArrayBuffer): void {
    const message: ServerMessage = decode(data);
    switch (message.type) {
      case 'frame':
        if (this.shows(message.sequence)) this.held.points(message);
        this.outside.post({ t: 'frame', message }, [data]);
        return;
      case 'depth':
        if (this.shows(message.sequence)) this.held.points(message);
        this.outside.post({ t: 'depth', message }, [data]);
        return;
      case 'annotation':
        this.annotation(message);
        return;
      case 'sequence':
        this.outside.post({ t: 'message', message });
        if (this.shows(message.id)) this.confirmed(message);
        return;
      default:
        this.outside.post({ t: 'message', message });
        this.settleBy(message);
    }
  }

  private confirmed(info: SequenceInfo): void {
    if (this.recording.state === 'closed') return;
    const { state, open, identity } = this.recording;
    let { revision } = this.recording;
    if (identity !== null && identity !== info.identity) {
      // Another recording was imported in its place: nothing from before is of use.
      this.held.clear();
      revision = null;
      if (this.outbox.abandon(identity)) this.report();
    }
    if (state !== 'live') this.held.resumed(info.revision);
    this.recording = {
      state: 'live',
      open,
      identity: info.identity,
      revision: revision ?? info.revision,
    };
    for (const edit of this.outbox.resend(info.identity)) this.transmit(edit);
  }

  private settleBy(message: ServerMessage): void {
    if (message.type === 'stroke_result' && message.final) this.settle(message.id);
    if (message.type === 'job' && message.kind === 'tracking') {
      if (this.outbox.settleTracks().length > 0) this.report();
    }
    if (message.type !== 'error') return;
    // Strokes of a revoked token wait for the next sign-in on this page.
    if (message.about !== null && message.status === UNAUTHORIZED) return;
    if (message.about !== null) this.settle(message.about);
    else if (this.recording.state === 'asked' && this.recording.revision !== null) {
      // The server does not have this revision (its database was restored): open from its newest one.
      this.recording = { ...this.recording, revision: null };
      this.transmit({ ...this.recording.open, revision: null });
    }
  }

  private annotation(message: Annotation): void {
    const lengths = unpackU32(message.lengths);
    const values = unpackU16(message.values);
    const { sequence, frame, revision, base, edit, provisional, first, count } = message;
    const range = { first, count, lengths, values };
    const update = { sequence, frame, revision, base, edit, provisional, ...range };
    this.outside.post({ t: 'labels', update }, labelBuffers(update));
    if (provisional || !this.shows(sequence) || this.recording.state === 'closed') return;
    const joins = this.held.values(message);
    if (base === null) return;
    // A delta that builds on one that never came: catch up.
    if (!joins && this.recording.state === 'live') {
      this.reopen();
      return;
    }
    const newest = Math.max(this.recording.revision ?? 0, revision);
    this.recording = { ...this.recording, revision: newest };
    if (edit !== null) this.settle(edit);
  }
}

function refusalOf(event: Closing): string {
  return REFUSALS.has(event.code) ? event.reason || 'The server refused this page.' : '';
}
