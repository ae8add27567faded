/** What a stroke will paint, found on the page's own points, shown until the server has answered. */
import { DELETED, type CloudFrame } from '../cloud/frame';
import { alongRay, firstHit, inCapsule, type Vec } from '../cloud/pick';
import type { Brush } from '../protocol/messages';
import type { PointerSample } from './sample';

/** Whether a label may not be changed. */
export type Locked = (label: number) => boolean;

export class StrokePreview {
  private readonly touched = new Set<number>();
  private last: Vec | null = null;
  private changed = false;

  constructor(
    readonly id: string,
    readonly frame: CloudFrame,
    private readonly brush: Brush,
    private readonly locked: Locked,
  ) {}

  /** Points that would change so far. */
  get size(): number {
    return this.touched.size;
  }

  /** Take in a sample; returns where the brush met the surface. */
  add(sample: PointerSample): Vec | null {
    const { brush } = this;
    const radius = brush.radius ?? 0.05;
    if (brush.shape === 'ray' && brush.through) {
      alongRay(this.frame, sample.origin, sample.direction, radius, this.touch);
      return null;
    }
    if (brush.shape === 'ray') {
      const hit = firstHit(this.frame, sample.origin, sample.direction, radius);
      if (hit) inCapsule(this.frame, hit.position, hit.position, radius, this.touch);
      return hit?.position ?? null;
    }
    if (brush.shape !== 'sphere') return null;
    inCapsule(this.frame, this.last ?? sample.origin, sample.origin, radius, this.touch);
    this.last = sample.origin;
    return sample.origin;
  }

  private readonly touch = (point: number): void => {
    if (this.touched.has(point)) return;
    const current = this.frame.storedLabelOf(point);
    if (!this.applies(current)) return;
    this.touched.add(point);
    this.changed = true;
  };

  private applies(current: number): boolean {
    const { tool, label, only_unlabeled: onlyUnlabeled } = this.brush;
    if (tool === 'restore') return current === DELETED;
    if (current === DELETED || this.locked(current)) return false;
    if (tool === 'erase') return current !== 0;
    if (tool === 'delete') return true;
    return current !== label && !(onlyUnlabeled && current !== 0);
  }

  /** Show what was found since the last call. */
  show(): void {
    if (!this.changed) return;
    this.changed = false;
    const indices = Uint32Array.from(this.touched).sort();
    const { tool, label } = this.brush;
    const value = tool === 'paint' ? (label ?? 0) : tool === 'delete' ? DELETED : 0;
    this.frame.setOverlay(this.id, { indices, values: Uint16Array.of(value) });
  }
}
