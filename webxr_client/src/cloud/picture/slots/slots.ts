/** The slots that a recording's frames are shown from, in turn: one on screen, the next being filled. */
import type { Group, WebGLRenderer } from 'three';
import { ALL_POINTS, type CloudFrame } from '../../points/frame';
import type { PointUniforms } from '../material';
import { Slot } from './slot';

const MOST = 3;

export class Slots {
  private readonly slots: Slot[] = [];
  private readonly most: number;
  private current: Slot | null = null;
  private limit = ALL_POINTS;

  /** For `frames` frames of at most `capacity` points, in a layer of the camera. */
  constructor(
    private readonly renderer: WebGLRenderer,
    private readonly uniforms: PointUniforms,
    frames: number,
    private readonly capacity: number,
    private readonly room: Group,
    private readonly layer: number,
  ) {
    this.most = Math.max(1, Math.min(MOST, frames));
  }

  /** Show a frame as it is now. */
  update(frame: CloudFrame): void {
    const slot = this.slotFor(frame);
    slot.upload(frame);
    if (slot === this.current) return;
    if (this.current) this.current.object.visible = false;
    slot.object.visible = true;
    this.current = slot;
  }

  /** Bring a frame to the GPU ahead of time. */
  prepare(frame: CloudFrame): void {
    if (this.most < 2) return;
    const slot = this.slotFor(frame);
    if (slot !== this.current) slot.upload(frame);
  }

  private slotFor(frame: CloudFrame): Slot {
    const { slots } = this;
    for (let i = 0; i < slots.length; i++) if (slots[i]!.frame === frame) return slots[i]!;
    if (slots.length < this.most) return this.add();
    // The one after the current was shown longest ago.
    const at = this.current ? slots.indexOf(this.current) : -1;
    return slots[(at + 1) % slots.length]!;
  }

  private add(): Slot {
    const slot = new Slot(this.renderer, this.uniforms, this.capacity, this.layer);
    slot.object.visible = false;
    slot.setLimit(this.limit);
    this.room.add(slot.object);
    this.slots.push(slot);
    return slot;
  }

  /** Draw at most about so many points. */
  setLimit(points: number): void {
    if (points === this.limit) return;
    this.limit = points;
    for (const slot of this.slots) slot.setLimit(points);
  }

  /** Draw depth images as surfaces, or no more. */
  showSurface(on: boolean): void {
    for (const slot of this.slots) slot.showSurface(on);
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
