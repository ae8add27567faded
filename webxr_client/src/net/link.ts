/** The page's end of the worker: typed messages in and out, nothing else. */
import type { ClientMessage, Open } from '../protocol/messages';
import type { FromWorker, Pace, ToWorker } from './wire';

const MOST_FREE = 4;

export class Link {
  private readonly free: ArrayBuffer[] = [];
  private readonly worker = new Worker(new URL('./worker.ts', import.meta.url), {
    type: 'module',
    name: 'pointbrush-net',
  });

  constructor(listen: (message: FromWorker) => void) {
    this.worker.onmessage = (event: MessageEvent<FromWorker>) => listen(event.data);
  }

  connect(): void {
    const url = new URL('api/v1/stream', document.baseURI);
    url.protocol = url.protocol === 'https:' ? 'wss:' : 'ws:';
    const probe = new URL('api/v1/me', document.baseURI).href;
    this.post({ t: 'connect', url: url.href, probe });
  }

  send(message: ClientMessage): void {
    this.post({ t: 'send', message });
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

  private post(message: ToWorker, transfer: Transferable[] = []): void {
    this.worker.postMessage(message, transfer);
  }
}
