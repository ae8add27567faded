/** What a stroke will paint, found on the page's own points, shown until the server has answered. */
import { type CloudFrame } from '../cloud/frame';
import { DELETED } from '../cloud/piece';
import { insideOutline } from '../cloud/inside';
import { alongRay, firstHit, inBox, inCapsule, type Vec } from '../cloud/pick';
import type { Brush } from '../protocol/messages';
import type { PointerSample } from './sample';
import type { Seen } from './seen';
import { Touched } from './touched';

/** Whether a label may not be changed. */
export type Locked = (label: number) => boolean;

export class StrokePreview {
  private readonly touched = new Touched();
  /** Where the ball was at the last sample. */
  private readonly last: [number, number, number] = [NaN, NaN, NaN];
  private readonly values: Uint16Array;

  constructor(
    readonly id: string,
    readonly frame: CloudFrame,
    private readonly brush: Brush,
    private readonly locked: Locked,
    private readonly seen: Seen,
    /** Source minus local coordinates. */
    shift: Vec,
  ) {
    const { tool, label } = brush;
    const value = tool === 'paint' ? (label ?? 0) : tool === 'delete' ? DELETED : 0;
    this.values = Uint16Array.of(value);
    this.take(shift);
  }

  /** Points that the stroke would change, as far as they were shown. */
  get points(): number {
    return this.touched.size;
  }

  /** The points of a shape that needs no samples. */
  private take([x, y, z]: Vec): void {
    const { shape, polygon, matrix, center, size, quaternion } = this.brush;
    if (shape === 'lasso' && polygon && matrix) {
      const clip = [...matrix];
      for (let row = 0; row < 16; row += 4) {
        clip[row + 3]! += matrix[row]! * x + matrix[row + 1]! * y + matrix[row + 2]! * z;
      }
      insideOutline(this.frame, polygon, clip, this.touch);
    }
    if (shape === 'box' && center && size) {
      const local: Vec = [center[0] - x, center[1] - y, center[2] - z];
      inBox(this.frame, local, size, quaternion ?? [0, 0, 0, 1], this.touch);
    }
  }

  /** Take in a sample. */
  add({ origin, direction }: PointerSample): void {
    const { brush, frame, last } = this;
    const radius = brush.radius ?? 0.05;
    if (brush.shape === 'ray' && brush.through) {
      alongRay(frame, origin, direction, radius, this.touch);
    } else if (brush.shape === 'ray') {
      const meets = brush.tool === 'restore' ? isDeleted : this.seen;
      const hit = firstHit(frame, origin, direction, radius, meets);
      if (hit) inCapsule(frame, hit.position, hit.position, radius, this.touch);
    } else if (brush.shape === 'sphere') {
      inCapsule(frame, Number.isNaN(last[0]) ? origin : last, origin, radius, this.touch);
      for (let k = 0; k < 3; k++) last[k] = origin[k]!;
    }
  }

  private readonly touch = (point: number): void => {
    if (!this.touched.meet(point)) return;
    if (this.applies(this.frame.storedLabelOf(point))) this.touched.take(point);
  };

  private applies(current: number): boolean {
    const { tool, label, only_unlabeled: onlyUnlabeled } = this.brush;
    if (tool === 'restore') return current === DELETED;
    if (!this.seen(current) || this.locked(current)) return false;
    if (tool === 'erase') return current !== 0;
    if (tool === 'delete') return true;
    return current !== label && !(onlyUnlabeled && current !== 0);
  }

  /** Show what was found since the last call. */
  show(): void {
    const { touched, values } = this;
    if (!touched.settle()) return;
    const indices = touched.numbers.subarray(0, touched.size);
    this.frame.setOverlay(this.id, { indices, values });
  }
}

function isDeleted(label: number): boolean {
  return label === DELETED;
}
