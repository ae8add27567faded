/** The GPU's side of frames that are laid over the one on screen: a slot for each. */
import type { Group, Matrix4, WebGLRenderer } from 'three';
import { ALL_POINTS, type CloudFrame } from '../../points/frame';
import type { PlacedFrame } from '../../points/layer';
import { Placement, type PointUniforms } from '../material';
import { Slot } from './slot';

interface PlacedSlot {
  readonly slot: Slot;
  readonly placement: Placement;
  placed: PlacedFrame;
  version: number;
  normals: Matrix4 | null;
}

export class PlacedFrames {
  private readonly placedSlots = new Map<CloudFrame, PlacedSlot>();
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
    for (const [frame, { slot, placement }] of this.placedSlots) {
      if (wanted.has(frame)) continue;
      slot.dispose();
      placement.dispose();
      this.placedSlots.delete(frame);
      changed = true;
    }
    for (const placed of frames) changed = this.lay(placed) || changed;
    if (changed) this.share();
    return changed;
  }

  private lay(placed: PlacedFrame): boolean {
    const { frame } = placed;
    const { normals } = this.uniforms;
    let placedSlot = this.placedSlots.get(frame);
    if (!placedSlot) {
      const placement = new Placement();
      const points = Math.max(1, frame.total);
      const slot = new Slot(this.renderer, this.uniforms, points, this.layer, placement);
      this.room.add(slot.object);
      placedSlot = { slot, placement, placed, version: -1, normals };
      placedSlot.placement.set(placed);
      this.placedSlots.set(frame, placedSlot);
    } else if (
      placedSlot.placed === placed &&
      placedSlot.version === frame.version &&
      placedSlot.normals === normals
    )
      return false;
    if (placedSlot.placed !== placed) placedSlot.placement.set(placed);
    placedSlot.placed = placed;
    placedSlot.version = frame.version;
    placedSlot.normals = normals;
    placedSlot.slot.upload(frame);
    return true;
  }

  /** Draw at most about so many points of all of them together. */
  setLimit(points: number): void {
    this.limit = points;
    this.share();
  }

  private share(): void {
    const each = Math.max(1, Math.floor(this.limit / Math.max(1, this.placedSlots.size)));
    for (const { slot } of this.placedSlots.values())
      slot.setLimit(this.limit === ALL_POINTS ? ALL_POINTS : each);
  }

  /** Points on screen. */
  get drawn(): number {
    return [...this.placedSlots.values()].reduce((sum, { slot }) => sum + slot.drawn, 0);
  }

  dispose(): void {
    this.show([]);
  }
}
