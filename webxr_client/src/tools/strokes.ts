/**
 * Strokes on their way: samples go to the server in batches, the preview shows meanwhile, and the
 * server's answer replaces it.
 */
import type { PointerSample, Vec } from '../store/types';
import type { CloudFrame } from '../cloud/points/frame';
import type { Layer } from '../cloud/points/layer';
import { notify } from '../store/state';
import type {
  Brush,
  ClientMessage,
  Sample,
  StrokeResult,
  StrokeSamples,
  TouchedPoints,
} from '../protocol/messages';
import { Listeners } from '../store/listeners';
import { type Locked, StrokePreview } from './preview';
import type { Seen } from './seen';

/** The preview stays at most this long after the answer, should the delta not come. */
const LINGER_MS = 2000;

export interface StrokeDeps {
  readonly send: (message: ClientMessage) => void;
  readonly locked: Locked;
  readonly seen: Seen;
  /** Labels that only this viewer hides. */
  readonly hidden: () => number[];
  /** Frames laid over the one on screen. */
  readonly layers: () => readonly Layer[];
  /** Labels on screen changed. */
  readonly changed: () => void;
  readonly now: () => number;
}

/** A stroke while its button or trigger is held. */
export interface Stroke {
  readonly id: string;
  /** The sample may be used again: it is copied.  `now`: when it was, milliseconds. */
  add(sample: PointerSample, now?: number): void;
  end(): void;
  /** Give it up: nothing of it stays. */
  cancel(): void;
}

/** A stroke that begins. */
export interface Begun {
  readonly id: string;
  readonly brush: Brush;
}

/** Samples for the next message, reused after it was sent, because posting copies them. */
class Batch {
  count = 0;
  private readonly pool: Required<Sample>[] = [];
  /** By number: the first samples of the pool.  An array that grows and shrinks is garbage too. */
  private readonly firsts: Required<Sample>[][] = [];

  /** Moment at which the stroke began, milliseconds. */
  constructor(private readonly started: number) {}

  add({ origin, direction }: PointerSample, shift: Vec, now: number): void {
    const sample = (this.pool[this.count++] ??= { origin: [0, 0, 0], direction: [0, 0, 0], t: 0 });
    for (let k = 0; k < 3; k++) {
      sample.origin[k] = origin[k]! + shift[k]!;
      sample.direction[k] = direction[k]!;
    }
    // A picture is dated from its beginning, which may be before the press.
    sample.t = Math.max(0, (now - this.started) | 0);
  }

  /** Samples added since the last call. */
  take(): Required<Sample>[] {
    const { count } = this;
    this.count = 0;
    return (this.firsts[count] ??= this.pool.slice(0, count));
  }
}

class LiveStroke implements Stroke {
  private readonly batch: Batch;
  private readonly message: StrokeSamples;
  readonly preview: StrokePreview;
  refused = false;
  /** Points that it takes, once it has ended; null: the server selects them. */
  taken: TouchedPoints[] | null = null;

  constructor(
    readonly id: string,
    frame: CloudFrame,
    brush: Brush,
    private readonly shift: Vec,
    private readonly deps: StrokeDeps,
    private readonly finished: (stroke: LiveStroke) => void,
  ) {
    this.batch = new Batch(deps.now());
    this.message = { type: 'stroke_samples', id, samples: [] };
    const layers = deps.layers();
    this.preview = new StrokePreview(id, frame, brush, deps.locked, deps.seen, shift, layers);
    const hidden = deps.hidden();
    deps.send({ type: 'stroke_begin', id, frame: frame.index, brush: { ...brush, hidden } });
  }

  add(sample: PointerSample, now = this.deps.now()): void {
    if (this.refused) return;
    this.batch.add(sample, this.shift, now);
    this.preview.add(sample);
  }

  /** Show the points found so far; true when there are samples to send. */
  show(): boolean {
    if (this.refused) return false;
    this.preview.show();
    this.deps.changed();
    return this.batch.count > 0;
  }

  /** Send the collected samples. */
  send(): void {
    if (this.refused || this.batch.count === 0) return;
    this.message.samples = this.batch.take();
    this.deps.send(this.message);
  }

  /** The server will not have it: nothing more to send or to show. */
  refuse(): void {
    this.refused = true;
    this.preview.drop();
  }

  cancel(): void {
    if (this.refused) return;
    this.refuse();
    this.deps.send({ type: 'stroke_cancel', id: this.id });
    this.finished(this);
    this.deps.changed();
  }

  end(): void {
    this.show();
    this.send();
    this.taken = this.preview.taken();
    if (!this.refused) this.deps.send({ type: 'stroke_end', id: this.id, touched: this.taken });
    this.finished(this);
  }
}

export class Strokes {
  private readonly live: LiveStroke[] = [];
  /** Ended, and waiting for the server. */
  private readonly ended = new Map<string, StrokePreview>();
  /** Points that strokes with their own points would change, until the server's count arrives. */
  private readonly expected = new Map<string, number>();
  /** Called with every answer: `touched` drives the haptic pulse. */
  readonly results = new Listeners<StrokeResult>();
  /** Called with every stroke that begins. */
  readonly begins = new Listeners<Begun>();

  constructor(private readonly deps: StrokeDeps) {}

  begin(frame: CloudFrame, brush: Brush, shift: Vec): Stroke {
    const stroke = new LiveStroke(crypto.randomUUID(), frame, brush, shift, this.deps, (done) => {
      this.live.splice(this.live.indexOf(done), 1);
      if (done.refused) return;
      this.ended.set(done.id, done.preview);
      if (done.taken) this.expected.set(done.id, done.preview.points);
    });
    this.live.push(stroke);
    this.begins.run({ id: stroke.id, brush });
    return stroke;
  }

  /** Whether one is being drawn. */
  get drawing(): boolean {
    return this.live.length > 0;
  }

  /** Before each picture; true when samples wait to be sent. */
  show(): boolean {
    let waiting = false;
    for (let i = 0; i < this.live.length; i++) waiting = this.live[i]!.show() || waiting;
    return waiting;
  }

  /** Send the collected samples. */
  send(): void {
    for (let i = 0; i < this.live.length; i++) this.live[i]!.send();
  }

  onResult(result: StrokeResult): void {
    this.results.run(result);
    if (!result.final) return;
    this.compare(result);
    // An unchanged frame gets no delta; otherwise the delta removes the preview.
    if (result.changed === 0) this.drop(result.id);
    else setTimeout(() => this.drop(result.id), LINGER_MS);
  }

  /** Warn of a stroke that changed fewer points than its preview. */
  private compare({ id, changed }: StrokeResult): void {
    const points = this.expected.get(id) ?? 0;
    this.expected.delete(id);
    if (changed >= points) return;
    const title = `${changed} of ${points} points changed`;
    notify('info', title, 'Another edit or a lock came in between.');
  }

  /** The server's own values are here, or it refused: the preview has served. */
  drop(id: string): void {
    for (const stroke of this.live) if (stroke.id === id) stroke.refuse();
    const preview = this.ended.get(id);
    if (!preview) return;
    this.ended.delete(id);
    preview.drop();
    this.deps.changed();
  }
}
