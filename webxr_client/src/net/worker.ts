/**
 * The worker that owns the socket.  What it hears goes to the page by way of the decoder, another
 * worker: a browser reads from a socket only while its thread is free.
 */
import { decode, encode, unpackU16, unpackU32 } from '../protocol/codec';
import {
  SCHEMA_HASH,
  SUBPROTOCOL,
  type Annotation,
  type ClientMessage,
  type Credit,
  type Open,
  type SequenceInfo,
  type ServerMessage,
} from '../protocol/messages';
import { Backoff } from './backoff';
import { HeldFrames } from './held';
import { begins, isEdit, Outbox } from './outbox';
import { MemoryStorage, openStorage } from './storage';
import { buffersOf } from './pairing';
import type { Decoded, LinkState, Pace, ToDecoder, ToWorker } from './wire';

/** Segments that the page may have waiting before the server must wait too. */
const MOST_WAITING = 6;
/** More than this unsent means that the link is stalled; what can be dropped is dropped. */
const SEND_LIMIT = 1 << 20;
const UNAUTHORIZED = 401;
const AT_ONCE = new Set<ToWorker['t']>(['decoder', 'connect', 'open', 'close']);

const backoff = new Backoff();
let outbox = new Outbox(new MemoryStorage());
/** Edits that the page has begun. */
let heard = 0;
let socket: WebSocket | null = null;
let address = '';
let probe = '';
/** What is open, or to be opened once online; kept for resuming. */
let opened: Open | null = null;
/** The import that `opened` named when the server last answered. */
let identity: string | null = null;
/** The server confirmed `opened`; edits may go out. */
let live = false;
const held = new HeldFrames();
/** The newest revision that the page has heard of. */
let revision: number | null = null;
/** Segments that the page has not taken in yet, and credits held back until it has. */
let waiting = 0;
let owed: Credit[] = [];
/** What the page last said of its pace. */
let pace: Pace = { points: null };
let timer: ReturnType<typeof setTimeout> | undefined;
/** The outbox is the one that earlier pages wrote to. */
let begun = false;

/** The way to the page. */
let decoder: MessagePort | null = null;

function post(message: ToDecoder, transfer: Transferable[] = []): void {
  decoder?.postMessage(message, transfer);
}

function link(state: LinkState, detail = '', retryMs: number | null = null): void {
  const unsent = state === 'refused' ? outbox.strokes() : [];
  post({ t: 'link', state, detail, retryMs, unsent });
}

function connect(): void {
  clearTimeout(timer);
  link('connecting');
  const current = new WebSocket(address, SUBPROTOCOL);
  let welcomed = false;
  current.binaryType = 'arraybuffer';
  socket = current;
  current.onopen = () => {
    welcomed = true;
    owed = [];
    backoff.reset();
    link('online');
    transmit({ type: 'hello', depth: true });
    reopen();
  };
  current.onmessage = (event: MessageEvent<ArrayBuffer>) => onceBegun(() => receive(event.data));
  current.onclose = (event) => {
    if (socket === current) void lost(event, welcomed);
  };
}

async function lost(event: CloseEvent, welcomed: boolean): Promise<void> {
  socket = null;
  live = false;
  const refusal = welcomed ? refusalOf(event) : await whyRefused();
  if (refusal) {
    link('refused', refusal);
    return;
  }
  const wait = backoff.next();
  link('offline', event.reason, wait);
  timer = setTimeout(connect, wait);
}

/** Close codes after which trying again cannot help. */
function refusalOf(event: CloseEvent): string {
  if (event.code === 4401 || event.code === 4403 || event.code === 1008) {
    return event.reason || 'The server refused this page.';
  }
  return '';
}

/** A browser does not say why a socket was refused; a plain request does. */
async function whyRefused(): Promise<string> {
  try {
    const response = await fetch(probe, { credentials: 'same-origin', cache: 'no-store' });
    if (response.status === 401)
      return 'This page has no valid token. Open the URL that the server printed.';
    if (response.status === 403) return 'The server does not accept pages from this address.';
    if (!response.ok) return '';
    const { schema } = (await response.json()) as { schema: string };
    if (schema !== SCHEMA_HASH) return 'This page is older than the server. Reload it.';
    return '';
  } catch {
    return '';
  }
}

/** Open again what is open, and hear what changed meanwhile. */
function reopen(): void {
  if (!opened) return;
  live = false;
  // One back: of the newest edit perhaps not every frame's part has come.
  if (revision === null) transmit(opened);
  else transmit({ ...opened, identity, revision: Math.max(0, revision - 1), held: held.list() });
}

function transmit(message: ClientMessage): void {
  if (socket?.readyState !== WebSocket.OPEN) return;
  // Where a person's hands are matters only now.
  if (message.type === 'presence' && socket.bufferedAmount > SEND_LIMIT) return;
  socket.send(encode(message));
}

function send(message: ClientMessage): void {
  if (message.type === 'stroke_cancel') {
    outbox.settle(message.id);
    report();
    if (!live) return;
  }
  if (isEdit(message)) {
    if (begins(message)) heard += 1;
    if (identity !== null) outbox.note(identity, message);
    report();
    if (!live) return;
  }
  if (message.type === 'forget') {
    held.forget(message.frames);
    post({ t: 'forget', frames: message.frames });
  }
  transmit(message);
}

function report(): void {
  post({ t: 'pending', count: outbox.size, heard });
}

function settle(id: string): void {
  if (outbox.settle(id)) report();
}

function receive(data: ArrayBuffer): void {
  const message: ServerMessage = decode(data);
  switch (message.type) {
    case 'frame': {
      if (message.sequence === opened?.sequence) held.points(message);
      post({ t: 'frame', message }, [data]);
      return;
    }
    case 'depth': {
      if (message.sequence === opened?.sequence) held.points(message);
      post({ t: 'depth', message }, [data]);
      return;
    }
    case 'annotation':
      annotation(message);
      return;
    case 'sequence':
      post({ t: 'message', message });
      if (opened?.sequence === message.id) confirmed(message);
      return;
    default:
      post({ t: 'message', message });
      settleBy(message);
  }
}

/** The decoder is done with a frame: the server may send another, unless the page lags behind. */
function decoded({ nbytes, decodeMs }: Decoded): void {
  waiting += 1;
  const credit: Credit = { type: 'credit', frames: 1, nbytes, decode_ms: decodeMs, ...pace };
  // A page that is busy drawing takes segments in late; the link is not to blame for that.
  if (waiting <= MOST_WAITING) transmit(credit);
  else owed.push(credit);
}

function confirmed(info: SequenceInfo): void {
  if (identity !== null && identity !== info.identity) {
    // Another recording was imported in its place: nothing from before is of use.
    held.clear();
    revision = null;
    if (outbox.abandon(identity)) report();
  }
  identity = info.identity;
  if (!live) held.resumed(info.revision);
  live = true;
  revision ??= info.revision;
  for (const edit of outbox.resend(identity)) transmit(edit);
}

function settleBy(message: ServerMessage): void {
  if (message.type === 'stroke_result' && message.final) settle(message.id);
  if (message.type === 'job' && message.kind === 'tracking') {
    if (outbox.settleTracks().length > 0) report();
  }
  if (message.type !== 'error') return;
  // What a revoked token painted waits for whoever signs in here next.
  if (message.about !== null && message.status === UNAUTHORIZED) return;
  if (message.about !== null) settle(message.about);
  else if (!live && opened && revision !== null) {
    // The server knows no such revision (its database was put back): start from what it has.
    revision = null;
    transmit({ ...opened, revision: null });
  }
}

function annotation(message: Annotation): void {
  const lengths = unpackU32(message.lengths);
  const values = unpackU16(message.values);
  const { sequence, frame, base, edit, provisional, first, count } = message;
  const range = { first, count, lengths, values };
  const update = { sequence, frame, revision: message.revision, base, edit, provisional, ...range };
  post({ t: 'labels', update }, buffersOf(update));
  if (provisional || opened?.sequence !== sequence) return;
  const gap = !held.values(message) && live && revision !== null;
  if (base === null) return;
  revision = gap ? revision : Math.max(revision ?? 0, message.revision);
  // A delta that builds on one that never came: catch up.
  if (gap) reopen();
  else if (edit !== null) settle(edit);
}

async function start(): Promise<void> {
  outbox = new Outbox(await openStorage());
  await outbox.restore();
  begun = true;
  report();
}

const started = start();

/** Now, or in its turn once the edits that an earlier page left are known. */
function onceBegun(act: () => void): void {
  if (begun) act();
  else void started.then(act);
}

function handle(message: ToWorker): void {
  switch (message.t) {
    case 'decoder':
      decoder = message.port;
      decoder.onmessage = (event: MessageEvent<Decoded>) => decoded(event.data);
      return;
    case 'connect':
      address = message.url;
      probe = message.probe;
      if (!socket) connect();
      return;
    case 'open':
      opened = message.message;
      live = false;
      identity = null;
      revision = null;
      held.clear();
      transmit(opened);
      return;
    case 'close':
      opened = null;
      live = false;
      identity = null;
      return;
    case 'send':
      send(message.message);
      return;
    case 'applied': {
      pace = message.pace;
      waiting -= 1;
      const credit = owed.shift();
      if (credit) transmit({ ...credit, ...pace });
      return;
    }
    case 'pace':
      pace = message.pace;
      transmit({ type: 'credit', frames: 0, ...pace });
  }
}

self.onmessage = (event: MessageEvent<ToWorker>) => {
  const message = event.data;
  // The way to the server is long: it need not wait for what the browser keeps on its disk.
  if (AT_ONCE.has(message.t)) handle(message);
  else onceBegun(() => handle(message));
};
self.addEventListener('online', () => {
  if (!socket && address) connect();
});
