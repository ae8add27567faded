/** Preview of a stroke that is still drawn or placed as one piece: shown until it is made. */
import { layers } from '../accumulation';
import type { CloudFrame } from '../cloud/frame';
import type { Vec } from '../cloud/pick';
import type { Brush } from '../protocol/messages';
import { StrokePreview, type Locked } from './preview';
import type { Seen } from './seen';

const OVERLAY = 'ahead';

export interface AheadDeps {
  readonly locked: Locked;
  readonly seen: Seen;
  /** Source minus local coordinates. */
  readonly shift: () => Vec;
  readonly changed: () => void;
}

export class AheadPreview {
  /** Points that the stroke would change. */
  points = 0;
  private frame: CloudFrame | null = null;
  private preview: StrokePreview | null = null;

  constructor(private readonly deps: AheadDeps) {}

  show(frame: CloudFrame, brush: Brush): void {
    if (this.frame !== frame) this.hide();
    const { locked, seen, shift, changed } = this.deps;
    const preview = new StrokePreview(OVERLAY, frame, brush, locked, seen, shift(), layers.peek());
    this.preview?.drop();
    preview.show();
    this.preview = preview;
    this.points = preview.points;
    this.frame = frame;
    changed();
  }

  hide(): void {
    if (this.preview) {
      this.preview.drop();
      this.deps.changed();
    }
    this.frame = this.preview = null;
    this.points = 0;
  }
}
