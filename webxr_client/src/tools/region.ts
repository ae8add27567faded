/** Preview of regions under the pointer, asked of the server and shown before the click. */
import type { PointerSample, Vec } from '../store/types';
import type { CloudFrame } from '../cloud/points/frame';
import { PREVIEW } from '../cloud/picture/palette';
import { DELETED } from '../cloud/points/piece';
import type { Brush, Candidates, ClientMessage } from '../protocol/messages';
import { numbersOf } from '../protocol/codec';
import { sourceSample } from './path';

const OVERLAY = 'region';

export interface RegionDeps {
  readonly send: (message: ClientMessage) => void;
  readonly frame: () => CloudFrame | null;
  readonly brush: () => Brush | null;
  /** Source minus local coordinates. */
  readonly shift: () => Vec;
  readonly changed: () => void;
}

interface Question {
  readonly id: string;
  readonly frame: CloudFrame;
  readonly brush: Brush;
  readonly sample: PointerSample;
}

export class RegionPreview {
  private pending: Question | null = null;
  private waiting: PointerSample | null = null;
  /** The question that was answered last, until the pointer leaves. */
  private answered: Question | null = null;

  constructor(private readonly deps: RegionDeps) {}

  /** The pointer is here; one question is on its way at a time. */
  hover(sample: PointerSample): void {
    if (this.pending) {
      this.waiting = sample;
      return;
    }
    const frame = this.deps.frame();
    const brush = this.deps.brush();
    if (!frame || !brush) return;
    const id = crypto.randomUUID();
    this.pending = { id, frame, brush, sample };
    const samples = [sourceSample(sample, this.deps.shift())];
    this.deps.send({ type: 'ask', id, frame: frame.index, brush, samples });
  }

  /** The pointer left, or the click was made. */
  leave(): void {
    this.waiting = null;
    this.pending = null;
    this.hide();
  }

  onCandidates(message: Candidates): void {
    const { pending, waiting } = this;
    if (pending?.id !== message.id) return;
    this.pending = null;
    this.waiting = null;
    this.hide();
    const region = message.candidates[0];
    if (region) {
      const { frame, brush } = pending;
      const value = brush.tool === 'paint' ? PREVIEW : brush.tool === 'delete' ? DELETED : 0;
      const indices = numbersOf(region.runs);
      frame.setOverlay(OVERLAY, { indices, values: Uint16Array.of(value) });
    }
    this.answered = pending;
    this.deps.changed();
    if (waiting) this.hover(waiting);
  }

  /** Labels of a frame changed, and with them the region of a press there: ask again. */
  onLabels(frame: number): void {
    const { pending } = this;
    if (pending?.frame.index === frame) this.waiting ??= pending.sample;
    else if (!pending && this.answered?.frame.index === frame) this.hover(this.answered.sample);
  }

  /** The server refused the question. */
  onError(about: string): void {
    if (this.pending?.id === about) this.leave();
  }

  private hide(): void {
    if (this.answered?.frame.dropOverlay(OVERLAY)) this.deps.changed();
    this.answered = null;
  }
}
