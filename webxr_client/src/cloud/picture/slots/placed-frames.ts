/** The GPU's side of frames that are laid over the one on screen: a slot for each. */
import type { Group, Matrix4, WebGLRenderer } from 'three';
import { ALL_POINTS, type CloudFrame } from '../../points/frame';
import type { PlacedFrame } from '../../points/layer';
import { Placement, type PointUniforms } from '../material';
import type { Slot } from './slot';
import { slotFor } from './slots';

interface Laid {
  readonly slot: Slot;
  readonly placement: Placement;
  placed: PlacedFrame;
  version: number;
  normals: Matrix4 | null;
}

export class PlacedFrames {
  private readonly laid = new Map<CloudFrame, Laid>();
  private limit = ALL_POINTS;

  /** In a layer of the camera. */
  constructor(
    private readonly renderer: WebGLRenderer,
    private readonly uniforms: PointUniforms,
    private readonly room: Group,
    private readonly layer: number,
  ) {}

  /** Show these frames, as they are now, and no others; true when the picture changed. */
  show(frames: readonly PlacedFrame[]): boolean {
    const wanted = new Set(frames.map(({ frame }) => frame));
    let changed = false;
    for (const [frame, { slot, placement }] of this.laid) {
      if (wanted.has(frame)) continue;
      slot.dispose();
      placement.dispose();
      this.laid.delete(frame);
      changed = true;
    }
    for (const placed of frames) changed = this.lay(placed) || changed;
    if (changed) this.share();
    return changed;
  }

  private lay(placed: PlacedFrame): boolean {
    const { frame } = placed;
    const { normals } = this.uniforms;
    let laid = this.laid.get(frame);
    if (!laid) {
      const placement = new Placement();
      const points = Math.max(1, frame.total);
      const slot = slotFor(frame, this.renderer, points, this.uniforms, placement);
      slot.object.traverse((part) => part.layers.set(this.layer));
      this.room.add(slot.object);
      laid = { slot, placement, placed, version: -1, normals };
      laid.placement.set(placed);
      this.laid.set(frame, laid);
    } else if (laid.placed === placed && laid.version === frame.version && laid.normals === normals)
      return false;
    if (laid.placed !== placed) laid.placement.set(placed);
    laid.placed = placed;
    laid.version = frame.version;
    laid.normals = normals;
    laid.slot.upload(frame);
    return true;
  }

  /** Draw at most about so many points of all of them together. */
  setLimit(points: number): void {
    this.limit = points;
    this.share();
  }

  private share(): void {
    const each = Math.max(1, Math.floor(this.limit / Math.max(1, this.laid.size)));
    for (const { slot } of this.laid.values())
      slot.setLimit(this.limit === ALL_POINTS ? ALL_POINTS : each);
  }

  /** Points on screen. */
  get drawn(): number {
    return [...this.laid.values()].reduce((sum, { slot }) => sum + slot.drawn, 0);
  }

  dispose(): void {
    this.show([]);
  }
}
