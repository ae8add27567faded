/** Boxes of objects at work: in the cloud, in the camera pictures, and around the chosen one. */
import type { Matrix4 } from 'three';
import { outlines } from '../cameras/state';
import type { Engine } from '../engine/engine';
import { boxes, chosenBox, FOLLOWS, picked, type ObjectBox, type Triple } from '../store/boxes';
import { state } from '../store/state';
import { peek, watch } from '../store/watch';
import { commitDraft, draft, shownIn } from './changes';
import { BoxWires, linesOf, type Drawn } from './drawing';
import { near, pointsNear, zoom } from './near';
import { shapeIn, type Shape } from './shape';
import { lessShift } from './volume';

/** Milliseconds between two updates of the points around the chosen box. */
const LOOK_MS = 120;

export class ObjectBoxes {
  private readonly wires = new BoxWires();
  private dirty = true;
  private looked = 0;
  /** State that the views show: frame, its version, box and zoom. */
  private seen: readonly unknown[] = [];
  private drawn: readonly Drawn[] = [];

  constructor(private readonly engine: Engine) {
    const { viewer } = engine;
    viewer.room.add(this.wires.group);
    const { shown, palette, solo, tool, view, xr } = state;
    watch([boxes, chosenBox, draft, shown, palette, solo, tool, view, xr], () => {
      this.dirty = true;
      viewer.invalidate();
    });
    watch([state.activeLabel], () => (picked.value = FOLLOWS));
    watch([state.frame, state.tool, chosenBox], () => {
      const now = draft.peek();
      if (!now) return;
      const same = now.frame === state.frame.peek() && now.id === chosenBox.peek()?.id;
      if (!same || state.tool.peek() !== 'boxes') commitDraft();
    });
    viewer.ticks.add((now) => this.update(now));
  }

  private update(now: number): void {
    if (this.dirty) {
      this.dirty = false;
      this.draw();
    }
    this.look(now);
  }

  private readonly on = (): boolean => peek(state.tool) === 'boxes' || peek(state.view).boxes;

  private draw(): void {
    const info = state.sequence.peek();
    this.drawn = info && this.on() ? this.shownNow(info.shift) : [];
    this.wires.grips = state.xr.peek().session === 'running';
    this.wires.show(this.drawn);
    outlines.value = this.drawn.map(({ shape, color, chosen, dashed, headed }) => ({
      color,
      chosen,
      dashed,
      ends: linesOf(shape, headed),
    }));
  }

  /** Boxes of the frame on screen, local coordinates. */
  private shownNow(shift: Triple): Drawn[] {
    const { frame } = state.shown.peek();
    const solo = state.solo.peek();
    const labels = new Map(state.palette.peek().map((label) => [label.id, label]));
    const chosen = state.tool.peek() === 'boxes' ? chosenBox.peek()?.id : undefined;
    return [...boxes.peek().values()].flatMap((box) => {
      const label = labels.get(box.label);
      const shape = shownIn(box, frame);
      const visible = solo === null ? label?.visible === true : solo === box.label;
      if (!label || !shape || !visible) return [];
      const pose = box.poses[frame]!;
      const local = lessShift(shape, shift);
      const { color, name } = label;
      const dashed = pose.provenance === 'fitted' && draft.peek()?.id !== box.id;
      return [{ shape: local, color, name, dashed, confidence: pose.confidence, chosen: box.id === chosen, headed: box.heading_known }]; // prettier-ignore
    });
  }

  /** Whether there are views of the chosen box at the side. */
  private readonly views = (): boolean =>
    peek(state.tool) === 'boxes' && peek(state.xr).session !== 'running';

  /** Collect the points around the chosen box once something about them changed. */
  private look(now: number): void {
    if (now - this.looked < LOOK_MS) return;
    this.looked = now;
    const frame = this.engine.frame();
    const box = this.views() ? peek(chosenBox) : null;
    const shape = frame && box && this.anchorOf(box, frame.index);
    const seen = [frame, frame?.version, shape && JSON.stringify(shape), peek(zoom)];
    if (seen.every((one, i) => one === this.seen[i])) return;
    this.seen = seen;
    near.value = frame && shape ? pointsNear(frame, shape, this.engine.shift()) : null;
  }

  /** While a box is dragged its views stand still. */
  private anchorOf(box: ObjectBox, frame: number): Shape | null {
    const now = draft.peek();
    return now?.id === box.id && now.frame === frame ? now.before : shapeIn(box, frame);
  }

  /** `T_room_local`. */
  get room(): Matrix4 {
    return this.engine.viewer.room.matrix;
  }
}
