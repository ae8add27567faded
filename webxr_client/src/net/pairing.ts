/** Points and the labels that come just ahead of them go to the page together: one wake-up, not two. */
import { buffersOf, type Segment } from './chunk/segment';
import type { FromWorker, LabelUpdate } from './wire';

type Post = (message: FromWorker, transfer: Transferable[]) => void;

export class Pairing {
  private labels: LabelUpdate | null = null;
  private timer: ReturnType<typeof setTimeout> | null = null;

  constructor(private readonly post: Post) {}

  /** Hold whole values until their points follow; without points, send them after a moment. */
  hold(update: LabelUpdate): void {
    this.flush();
    this.labels = update;
    this.timer ??= setTimeout(() => {
      this.timer = null;
      this.flush();
    }, 0);
  }

  segment(segment: Segment): void {
    if (this.labels?.frame !== segment.frame) this.flush();
    const { labels } = this;
    this.labels = null;
    this.post({ t: 'segment', segment, labels }, [...buffersOf(segment), ...labelBuffers(labels)]);
  }

  /** To be called ahead of everything else that is posted: nothing overtakes labels. */
  flush(): void {
    const { labels } = this;
    this.labels = null;
    if (labels) this.post({ t: 'labels', update: labels }, labelBuffers(labels));
  }
}

export function labelBuffers(labels: LabelUpdate | null): ArrayBuffer[] {
  return labels ? [labels.lengths.buffer, labels.values.buffer] : [];
}
