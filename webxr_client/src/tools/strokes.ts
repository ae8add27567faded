/**
 * Strokes on their way: samples go to the server in batches, the preview shows meanwhile, and the
 * server's answer replaces it.
 */
import type { CloudFrame } from '../cloud/frame';
import type { Vec } from '../cloud/pick';
import type { Brush, ClientMessage, Sample, StrokeResult } from '../protocol/messages';
import { StrokePreview, type Locked } from './preview';
import type { PointerSample } from './sample';

/** The preview stays at most this long after the answer, should the delta not come. */
const LINGER_MS = 2000;

export interface StrokeDeps {
  readonly send: (message: ClientMessage) => void;
  readonly locked: Locked;
  /** Labels on screen changed. */
  readonly changed: () => void;
  readonly now: () => number;
}

/** A stroke while its button or trigger is held. */
export interface Stroke {
  readonly id: string;
  /** `pressed` milliseconds are filled in; returns where the brush met the surface. */
  add(sample: PointerSample): Vec | null;
  end(): void;
  /** Points that the page expects to change. */
  readonly expected: number;
}

class LiveStroke implements Stroke {
  private readonly waiting: Sample[] = [];
  private readonly started: number;
  readonly preview: StrokePreview;
  refused = false;

  constructor(
    readonly id: string,
    frame: CloudFrame,
    brush: Brush,
    private readonly shift: Vec,
    private readonly deps: StrokeDeps,
    private readonly finished: (stroke: LiveStroke) => void,
  ) {
    this.started = deps.now();
    this.preview = new StrokePreview(id, frame, brush, deps.locked);
    deps.send({ type: 'stroke_begin', id, frame: frame.index, brush });
  }

  get expected(): number {
    return this.preview.size;
  }

  add(sample: PointerSample): Vec | null {
    const [x, y, z] = sample.origin;
    const [dx, dy, dz] = sample.direction;
    this.waiting.push({
      origin: [x + this.shift[0], y + this.shift[1], z + this.shift[2]],
      direction: [dx, dy, dz],
      t: this.deps.now() - this.started,
    });
    return this.preview.add(sample);
  }

  /** Send what has gathered; once per picture. */
  flush(): void {
    if (this.refused) return;
    if (this.waiting.length > 0) {
      this.deps.send({ type: 'stroke_samples', id: this.id, samples: this.waiting.splice(0) });
    }
    this.preview.show();
    this.deps.changed();
  }

  /** The server will not have it: nothing more to send or to show. */
  refuse(): void {
    this.refused = true;
    this.preview.frame.dropOverlay(this.id);
  }

  end(): void {
    this.flush();
    if (!this.refused) this.deps.send({ type: 'stroke_end', id: this.id });
    this.finished(this);
  }
}

export type ResultListener = (result: StrokeResult) => void;

export class Strokes {
  private readonly live = new Set<LiveStroke>();
  /** Ended, and waiting for the server. */
  private readonly ended = new Map<string, StrokePreview>();
  /** Told every answer: `touched` drives the haptic pulse. */
  readonly results = new Set<ResultListener>();

  constructor(private readonly deps: StrokeDeps) {}

  begin(frame: CloudFrame, brush: Brush, shift: Vec): Stroke {
    const stroke = new LiveStroke(crypto.randomUUID(), frame, brush, shift, this.deps, (done) => {
      this.live.delete(done);
      if (!done.refused) this.ended.set(done.id, done.preview);
    });
    this.live.add(stroke);
    return stroke;
  }

  /** Once per picture. */
  flush(): void {
    if (this.live.size === 0) return;
    for (const stroke of this.live) stroke.flush();
  }

  get active(): boolean {
    return this.live.size > 0;
  }

  onResult(result: StrokeResult): void {
    for (const listen of this.results) listen(result);
    if (!result.final) return;
    // What did not change needs no delta; otherwise the delta takes the preview away.
    if (result.changed === 0) this.drop(result.id);
    else setTimeout(() => this.drop(result.id), LINGER_MS);
  }

  /** The server's own values are here, or it refused: the preview has served. */
  drop(id: string): void {
    for (const stroke of this.live) if (stroke.id === id) stroke.refuse();
    const preview = this.ended.get(id);
    if (!preview) return;
    this.ended.delete(id);
    preview.frame.dropOverlay(id);
    this.deps.changed();
  }
}
