/** Overlays on the recording, at the desk and in the headset: boxes, trails, a ghost. */
import { clipInRoom } from '../tools/clip';
import type { CloudFrame } from '../cloud/points/frame';
import type { Engine } from '../engine/engine';
import { unsure } from '../engine/review';
import { peek, watch } from '../store/watch';
import { state } from '../store/state';
import { boxedLabels } from '../store/boxes';
import { Boxes } from './boxes';
import { Ghost, isGhostAllowed } from './ghost';
import { Summaries, type Summary } from './summary';
import { PLACES, REACH, Trails } from './trails';

export class Overlays {
  readonly boxes: Boxes;
  readonly trails: Trails;
  readonly ghost: Ghost;
  private readonly summaries = new Summaries();
  /** The palette or the view settings changed. */
  private dirty = true;
  private head = -1;
  /** Direction of the last step in time: 1 is forward. */
  private direction = 1;
  private boxed: CloudFrame | null = null;
  private seen = -1;
  private ghostOf: CloudFrame | null = null;
  private ghostVersion = -1;
  private next = 0;
  /** Placement of the recording at the last update. */
  private room: readonly number[] | null = null;

  constructor(private readonly engine: Engine) {
    const { world, room, uniforms } = engine.viewer;
    this.boxes = new Boxes(world);
    this.trails = new Trails(world, uniforms);
    this.ghost = new Ghost(room, uniforms);
    const { palette, solo, view, activeLabel, sequence, playing } = state;
    const of = [palette, solo, view, activeLabel, sequence, playing, unsure, clipInRoom];
    watch([...of, boxedLabels], () => {
      this.dirty = true;
      engine.viewer.invalidate();
    });
  }

  /** Update at most one frame in each picture, which bounds the cost. */
  update(now: number): void {
    const info = peek(state.sequence);
    const view = peek(state.view);
    const { boxes, trails } = view;
    const frame = this.engine.playback.frame;
    if (!info || info.large || !frame) {
      this.boxes.hide();
      this.trails.hide();
      this.ghost.hide();
      return;
    }
    this.standIn(info.room);
    const moved = this.follow(peek(state.frame));
    if (boxes || trails) this.look(frame, trails, now);
    const news = this.dirty || this.seen !== this.summaries.version;
    if (news || frame !== this.boxed) this.box(frame, boxes);
    if (news || moved) this.updateTrails(info.frames, trails);
    this.updateGhost(isGhostAllowed(view, peek(state.playing), peek(unsure).length > 0));
    this.seen = this.summaries.version;
    this.dirty = false;
  }

  private standIn(room: readonly number[]): void {
    if (room === this.room) return;
    this.room = room;
    this.summaries.forget();
  }

  private follow(head: number): boolean {
    if (head === this.head) return false;
    if (this.head >= 0) this.direction = head < this.head ? -1 : 1;
    this.head = head;
    return true;
  }

  /** The frame on screen, or else the next one near it that changed. */
  private look(frame: CloudFrame, around: boolean, now: number): void {
    const { room } = this.engine.viewer;
    if (this.summaries.stale(frame)) {
      this.summaries.of(frame, room.matrix, now);
      return;
    }
    if (!around) return;
    this.next = (this.next + 1) % PLACES;
    const other = this.engine.playback.store.get(this.head - REACH + this.next);
    if (other && this.summaries.stale(other)) this.summaries.of(other, room.matrix, now);
  }

  private box(frame: CloudFrame, on: boolean): void {
    this.boxed = frame;
    const summary = on ? this.summaries.peek(frame) : null;
    if (summary) this.boxes.show(summary, peek(clipInRoom));
    else this.boxes.hide();
    this.engine.viewer.invalidate();
  }

  private readonly summaryOf = (index: number): Summary | null => {
    const frame = this.engine.playback.store.get(index);
    return frame ? this.summaries.peek(frame) : null;
  };

  private updateTrails(frames: number, on: boolean): void {
    const { trails, summaryOf } = this;
    if (on) trails.show(this.head, frames, peek(state.palette), summaryOf, peek(clipInRoom));
    else trails.hide();
    this.engine.viewer.invalidate();
  }

  /** The frame that one has just come from. */
  private updateGhost(on: boolean): void {
    const frame = on ? (this.engine.playback.store.get(this.head - this.direction) ?? null) : null;
    const version = frame?.version ?? -1;
    if (!this.dirty && frame === this.ghostOf && version === this.ghostVersion) return;
    this.ghostOf = frame;
    this.ghostVersion = version;
    if (frame) this.ghost.show(frame, peek(state.activeLabel));
    else this.ghost.hide();
    this.engine.viewer.invalidate();
  }
}

/** Wire the overlays to the engine. */
export function installOverlays(engine: Engine): Overlays {
  const overlays = new Overlays(engine);
  engine.viewer.ticks.add((now) => overlays.update(now));
  return overlays;
}
