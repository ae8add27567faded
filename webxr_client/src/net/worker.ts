/**
 * The worker that owns the socket.  Received messages go to the page through the decoder, another
 * worker: a browser reads from a socket only while its thread is free.
 */
import { SCHEMA_HASH, SUBPROTOCOL } from '../protocol/messages';
import { supported } from './depth/kernel';
import { Session, type Socket, type SocketHandlers } from './session';
import { openStorage } from './storage';
import type { Decoded, ToDecoder, ToWorker } from './wire';

/** Addresses of the socket, and of a plain request that is refused for the same reasons. */
let addresses: { readonly socket: string; readonly probe: string } | null = null;
/** The way to the page. */
let decoder: MessagePort | null = null;

function dial(handlers: SocketHandlers): Socket {
  const socket = new WebSocket(addresses?.socket ?? '', SUBPROTOCOL);
  socket.binaryType = 'arraybuffer';
  socket.onopen = () => handlers.opened(socket);
  socket.onmessage = (event: MessageEvent<ArrayBuffer>) => handlers.received(event.data);
  socket.onclose = (event) => handlers.closed(socket, event);
  return socket;
}

async function whyRefused(): Promise<string> {
  try {
    const response = await fetch(addresses?.probe ?? '', {
      credentials: 'same-origin',
      cache: 'no-store',
    });
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

function post(message: ToDecoder, transfer: Transferable[] = []): void {
  decoder?.postMessage(message, transfer);
}

function after(ms: number, act: () => void): () => void {
  const timer = setTimeout(act, ms);
  return () => clearTimeout(timer);
}

// Connecting takes long: it does not wait for the edits on the browser's disk.
const session = new Session({ depth: supported, dial, whyRefused, post, after });
void openStorage().then((storage) => session.restore(storage));

self.onmessage = ({ data: message }: MessageEvent<ToWorker>) => {
  switch (message.t) {
    case 'decoder':
      decoder = message.port;
      decoder.onmessage = (event: MessageEvent<Decoded>) => session.decoded(event.data);
      return;
    case 'connect':
      addresses = { socket: message.url, probe: message.probe };
      session.connect();
      return;
    case 'open':
      session.open(message.message);
      return;
    case 'close':
      session.close();
      return;
    case 'send':
      session.send(message.message);
      return;
    case 'applied':
      session.applied(message.pace);
      return;
    case 'pace':
      session.paced(message.pace);
  }
};
self.addEventListener('online', () => {
  if (addresses) session.connect();
});
