/** The page's end of the workers: typed messages to the socket, and from it by way of the decoder. */
import type { ClientMessage } from '../protocol/messages';
import { begins } from './outbox';
import { apiUrl } from './rest';
import type { FromPage, FromWorker, ToWorker } from './wire';

const MOST_FREE = 4;
const NOTHING: Transferable[] = [];

export class Link {
  private readonly free: ArrayBuffer[] = [];
  /** Reused for every message, because posting copies it at once. */
  private sent: { t: 'send'; message: ClientMessage } | null = null;
  private readonly worker = new Worker(new URL('./worker.ts', import.meta.url), {
    type: 'module',
    name: 'pointbrush-net',
  });
  private readonly decoder = new Worker(new URL('./decoder.ts', import.meta.url), {
    type: 'module',
    name: 'pointbrush-decoder',
  });

  /** Number of edits begun here; the worker receives them a little later. */
  private begun = 0;
  /** Last number of unanswered edits from the worker, minus the edits that it had received. */
  private unanswered = 0;

  /** Called with every message that the page sends, if set. */
  observer: ((message: ClientMessage) => void) | null = null;

  private listener: ((message: FromWorker) => void) | null = null;
  /** Messages received before there was a listener. */
  private readonly undelivered: FromWorker[] = [];

  constructor() {
    this.decoder.onmessage = (event: MessageEvent<FromWorker>) => this.receive(event.data);
    const { port1, port2 } = new MessageChannel();
    this.post({ t: 'decoder', port: port1 }, [port1]);
    this.postToDecoder({ t: 'socket', port: port2 }, [port2]);
  }

  /** Receive all messages, from the first one on. */
  listen(listener: (message: FromWorker) => void): void {
    this.listener = listener;
    for (const message of this.undelivered.splice(0)) listener(message);
  }

  connect(): void {
    const url = new URL(apiUrl('stream'));
    url.protocol = url.protocol === 'https:' ? 'wss:' : 'ws:';
    this.post({ t: 'connect', url: url.href, probe: apiUrl('me') });
  }

  send(message: ClientMessage): void {
    if (this.sent) this.sent.message = message;
    else this.sent = { t: 'send', message };
    this.post(this.sent);
    this.observer?.(message);
    if (!begins(message)) return;
    this.begun += 1;
    this.reportPending();
  }

  /** Give buffers back, a few at a time. */
  recycle(buffers: ArrayBuffer[]): void {
    this.free.push(...buffers);
    if (this.free.length <= MOST_FREE) return;
    const all = this.free.splice(0);
    this.postToDecoder({ t: 'recycle', buffers: all }, all);
  }

  private receive(message: FromWorker): void {
    if (message.t !== 'pending') {
      this.deliver(message);
      return;
    }
    this.unanswered = message.count - message.received;
    this.reportPending();
  }

  /** Count edits that the worker has not received yet: they have no answer either. */
  private reportPending(): void {
    const count = this.unanswered + this.begun;
    this.deliver({ t: 'pending', count, received: this.begun });
  }

  private deliver(message: FromWorker): void {
    if (this.listener) this.listener(message);
    else this.undelivered.push(message);
  }

  /** Tell the worker of the socket. */
  post(message: ToWorker, transfer: Transferable[] = NOTHING): void {
    this.worker.postMessage(message, transfer);
  }

  private postToDecoder(message: FromPage, transfer: Transferable[]): void {
    this.decoder.postMessage(message, transfer);
  }
}
