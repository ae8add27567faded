/** The worker between the socket and the page: decodes points, and hands all on in the order it came. */
import { decodeFrame, ready } from './decode';
import { buffersOf, Pairing } from './pairing';
import { BufferPool } from './pool';
import type { Decoded, FromPage, FromWorker, ToDecoder } from './wire';

const POOL_BYTES = 64 << 20;

const pool = new BufferPool(POOL_BYTES);

function post(message: FromWorker, transfer: Transferable[]): void {
  (self as unknown as Worker).postMessage(message, transfer);
}

const pairing = new Pairing(post);

function forward(message: ToDecoder, socket: MessagePort): void {
  if (message.t === 'frame') {
    const segment = decodeFrame(message.message, pool);
    const { nbytes, decodeMs } = segment;
    pairing.segment(segment);
    const decoded: Decoded = { nbytes, decodeMs };
    socket.postMessage(decoded);
  } else if (message.t === 'labels' && message.update.base === null) {
    pairing.hold(message.update);
  } else {
    pairing.flush();
    post(message, message.t === 'labels' ? buffersOf(message.update) : []);
  }
}

self.onmessage = (event: MessageEvent<FromPage>) => {
  const message = event.data;
  if (message.t === 'recycle') {
    for (const buffer of message.buffers) pool.give(buffer);
    return;
  }
  const { port } = message;
  // What comes before the codec is there waits in the port.
  void ready.then(() => {
    port.onmessage = (event: MessageEvent<ToDecoder>) => forward(event.data, port);
  });
};
