/** The slots that a recording's frames are shown from, in turn: one on screen, the next being filled. */
import type { Group, WebGLRenderer } from 'three';
import { ALL_POINTS, type CloudFrame } from '../points/frame';
import type { PointUniforms } from './material';
import { Slot } from './slot';

const MOST = 3;

export class Slots {
  private readonly slots: readonly Slot[];
  private current: Slot | null = null;
  private limit = ALL_POINTS;

  /** For `frames` frames of at most `capacity` points, in a layer of the camera. */
  constructor(
    renderer: WebGLRenderer,
    uniforms: PointUniforms,
    frames: number,
    capacity: number,
    room: Group,
    layer: number,
  ) {
    const count = Math.max(1, Math.min(MOST, frames));
    this.slots = Array.from({ length: count }, () => new Slot(renderer, capacity, uniforms));
    for (const { points } of this.slots) {
      points.layers.set(layer);
      room.add(points);
    }
  }

  /** Show a frame as it is now. */
  update(frame: CloudFrame): void {
    const slot = this.slotFor(frame);
    slot.upload(frame);
    if (slot === this.current) return;
    if (this.current) this.current.points.visible = false;
    slot.points.visible = true;
    this.current = slot;
  }

  /** Bring a frame to the GPU ahead of time. */
  prepare(frame: CloudFrame): void {
    if (this.slots.length < 2) return;
    const slot = this.slotFor(frame);
    if (slot !== this.current) slot.upload(frame);
  }

  private slotFor(frame: CloudFrame): Slot {
    const { slots } = this;
    for (let i = 0; i < slots.length; i++) if (slots[i]!.frame === frame) return slots[i]!;
    // The one after the current was shown longest ago.
    const at = this.current ? slots.indexOf(this.current) : -1;
    return slots[(at + 1) % slots.length]!;
  }

  /** Draw at most about so many points. */
  setLimit(points: number): void {
    if (points === this.limit) return;
    this.limit = points;
    for (let i = 0; i < this.slots.length; i++) this.slots[i]!.setLimit(points);
  }

  /** Points on screen. */
  get drawn(): number {
    return this.current?.drawn ?? 0;
  }

  /** Points on screen with each label. */
  countLabels(): Map<number, number> {
    return this.current?.countLabels() ?? new Map<number, number>();
  }

  dispose(): void {
    for (const slot of this.slots) slot.dispose();
  }
}
