/** The page's end of the worker: typed messages in and out. */
import type { ClientMessage, Open } from '../protocol/messages';
import { begins } from './outbox';
import type { FromWorker, Pace, ToWorker } from './wire';

const MOST_FREE = 4;
const NOTHING: Transferable[] = [];

export class Link {
  private readonly free: ArrayBuffer[] = [];
  /** Used again and again: what is posted is copied at once. */
  private sent: { t: 'send'; message: ClientMessage } | null = null;
  private readonly worker = new Worker(new URL('./worker.ts', import.meta.url), {
    type: 'module',
    name: 'pointbrush-net',
  });

  /** Edits begun here; the worker hears of them a little later. */
  private begun = 0;
  /** How many edits more than it had heard of the worker last said to be without an answer. */
  private unanswered = 0;

  constructor(private readonly listen: (message: FromWorker) => void) {
    this.worker.onmessage = (event: MessageEvent<FromWorker>) => this.receive(event.data);
  }

  connect(): void {
    const url = new URL('api/v1/stream', document.baseURI);
    url.protocol = url.protocol === 'https:' ? 'wss:' : 'ws:';
    const probe = new URL('api/v1/me', document.baseURI).href;
    this.post({ t: 'connect', url: url.href, probe });
  }

  send(message: ClientMessage): void {
    if (this.sent) this.sent.message = message;
    else this.sent = { t: 'send', message };
    this.post(this.sent);
    if (!begins(message)) return;
    this.begun += 1;
    this.reportPending();
  }

  open(message: Open): void {
    this.post({ t: 'open', message });
  }

  close(): void {
    this.post({ t: 'close' });
  }

  applied(pace: Pace, buffers: ArrayBuffer[]): void {
    const all = this.free.splice(0).concat(buffers);
    this.post({ t: 'applied', pace, buffers: all }, all);
  }

  pace(pace: Pace): void {
    this.post({ t: 'pace', pace });
  }

  /** Give buffers back; a few of them wait for the next message that goes anyway. */
  recycle(buffers: ArrayBuffer[]): void {
    this.free.push(...buffers);
    if (this.free.length <= MOST_FREE) return;
    const all = this.free.splice(0);
    this.post({ t: 'recycle', buffers: all }, all);
  }

  private receive(message: FromWorker): void {
    if (message.t !== 'pending') {
      this.listen(message);
      return;
    }
    this.unanswered = message.count - message.heard;
    this.reportPending();
  }

  /** What the worker has not heard of yet has no answer either. */
  private reportPending(): void {
    const count = this.unanswered + this.begun;
    this.listen({ t: 'pending', count, heard: this.begun });
  }

  private post(message: ToWorker, transfer: Transferable[] = NOTHING): void {
    this.worker.postMessage(message, transfer);
  }
}
