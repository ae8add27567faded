/** The worker between the socket and the page: decodes points, and hands all on in the order it came. */
import type { SequenceInfo } from '../protocol/messages';
import { decodeFrame, ready } from './chunk/decode';
import { DepthDecoder } from './depth/decode';
import { readPicture } from './depth/pictures';
import { InOrder } from './in-order';
import { labelBuffers, Pairing } from './pairing';
import { BufferPool } from './chunk/pool';
import type { Segment } from './chunk/segment';
import type { Decoded, FromPage, FromWorker, ToDecoder } from './wire';

const POOL_BYTES = 64 << 20;

const pool = new BufferPool(POOL_BYTES);
const depth = new DepthDecoder(pool, readPicture);
const inOrder = new InOrder();
/** The recording of the frames that follow. */
let info: SequenceInfo | null = null;

function post(message: FromWorker, transfer: Transferable[]): void {
  (self as unknown as Worker).postMessage(message, transfer);
}

const pairing = new Pairing(post);

function receive(message: ToDecoder, socket: MessagePort): void {
  if (message.t !== 'depth') {
    inOrder.add(() => forward(message, socket));
    return;
  }
  // Pictures are read while earlier messages are decoded.
  const coming = depth.receive(message.message);
  inOrder.add(async () => handOn(await depth.decode(coming), socket));
}

function forward(message: Exclude<ToDecoder, { t: 'depth' }>, socket: MessagePort): void {
  if (message.t === 'frame') {
    handOn(decodeFrame(message.message, info!, pool), socket);
  } else if (message.t === 'forget') {
    depth.forget(message.frames);
  } else if (message.t === 'labels' && message.update.base === null) {
    pairing.hold(message.update);
  } else {
    if (message.t === 'message' && message.message.type === 'sequence') {
      info = message.message;
      depth.open(info);
    }
    pairing.flush();
    post(message, message.t === 'labels' ? labelBuffers(message.update) : []);
  }
}

function handOn(segment: Segment, socket: MessagePort): void {
  const { nbytes, decodeMs } = segment;
  pairing.segment(segment);
  const decoded: Decoded = { nbytes, decodeMs };
  socket.postMessage(decoded);
}

self.onmessage = (event: MessageEvent<FromPage>) => {
  const message = event.data;
  if (message.t === 'recycle') {
    for (const buffer of message.buffers) pool.give(buffer);
    return;
  }
  const { port } = message;
  // Messages from before the codec is there wait in the port.
  void ready.then(() => {
    port.onmessage = (event: MessageEvent<ToDecoder>) => receive(event.data, port);
  });
};
