/** Visible parts of a pointer: its model, its ray, its tips; and the panel that it is on. */
import type { Matrix4, Object3D } from 'three';
import { BUTTON_TICK } from '../input/haptics';
import type { Model, Spots } from '../input/kind';
import { drawnSpots, Ray } from '../input/model';
import { Switch } from '../input/pad';
import type { Painter } from '../painting/painter';
import type { Panel } from '../panels/panel';
import type { Pointer } from '../input/pointer';
import type { Lessons, Part } from '../input/lessons';
import { Tips } from './tips';

/** Metres before a panel at which a fingertip comes near, is on it, and has let go again. */
const APPROACH = 0.12;
const HOVER = 0.05;
const LET_GO = 0.008;

export class Body {
  readonly tips: Tips;
  readonly spots: Spots;
  /** The panel that its ray or its fingertip is on. */
  on: Panel | null = null;
  private readonly model: Model | null;
  private readonly ray = new Ray();
  /** The fingertip's press: it must come from before the panel. */
  private readonly touchSwitch = new Switch();
  private before: Panel | null = null;
  private isTouching = false;
  /** The part that its words are for. */
  private explained: Part | null = null;
  /** Seconds for which it has been out of sight. */
  readonly unseen = new Float64Array(1);

  constructor(
    readonly pointer: Pointer,
    lessons: Lessons,
    scene: Object3D,
    rig: Object3D,
  ) {
    rig.add(pointer.grip);
    scene.add(this.ray.line.mesh);
    this.model = pointer.kind.model(pointer.source, pointer.device);
    this.spots = this.model?.spots ?? drawnSpots();
    this.tips = new Tips(lessons, pointer, this.spots);
    if (this.model) (this.model.gripped ? pointer.grip : rig).add(this.model.object);
  }

  /** Take in a bare hand's joints; `rig` is where the headset's space lies in the scene. */
  follow(frame: XRFrame, space: XRReferenceSpace, rig: Matrix4): void {
    const { pointer, model } = this;
    if (!model || model.gripped) return;
    model.update?.(frame, space);
    pointer.hasPinch = model.pinch?.(pointer.pinch) ?? false;
    if (pointer.hasPinch) pointer.pinch.applyMatrix4(rig);
    pointer.hasFingertip = model.fingertip?.(pointer.fingertip) ?? false;
    if (pointer.hasFingertip) pointer.fingertip.applyMatrix4(rig);
  }

  /** Write the functions of its buttons; transient inputs have no hints. */
  explain(part: Part): void {
    if (!this.pointer.holds || this.explained === part) return;
    this.explained = part;
    this.tips.set(part);
  }

  /** Point it at the panels; a held panel keeps it. `painter`: its brush, or null. */
  point(panels: readonly Panel[], painter: Painter | null): void {
    const { pointer } = this;
    const free = pointer.tracked && !painter?.painting;
    const poked = free && pointer.hasFingertip ? this.poked(panels) : null;
    if (this.isTouching && !poked) this.leave();
    this.isTouching = poked !== null;
    const nearest = poked ?? (free ? this.nearest(panels, false) : null);
    const touch = this.touchSwitch.update(poked ? this.touchOf(poked) : 0);
    if (this.on !== nearest) this.leave();
    this.on = nearest;
    if (nearest?.point(poked ? touch : pointer.edge.click, this)) {
      pointer.pulse(BUTTON_TICK.strength, BUTTON_TICK.milliseconds);
    }
    this.drawRay(poked ? null : nearest, painter);
  }

  /** The panel carried by its ray; a fingertip cannot release a panel that follows it. */
  get carries(): Panel | null {
    return !this.isTouching && this.on?.carried === true ? this.on : null;
  }

  private leave(): void {
    this.on?.leave(this);
    this.on = null;
  }

  /** The panel that the fingertip is at (`isTouching`), or that the ray meets first. */
  private nearest(panels: readonly Panel[], isTouching: boolean): Panel | null {
    const { pointer, on } = this;
    const held = on?.heldBy(this) ? on : null;
    let nearest: Panel | null = null;
    for (let i = 0; i < panels.length; i++) {
      const panel = panels[i]!;
      if (held ? panel !== held : !panel.isFree) continue;
      const met = isTouching
        ? panel.touched(pointer.fingertip, APPROACH)
        : panel.meet(pointer.origin, pointer.direction);
      if (!met || (nearest && panel.distance[0]! >= nearest.distance[0]!)) continue;
      nearest = panel;
    }
    return nearest;
  }

  /** The panel that the fingertip is at; one that it comes near to is noted. */
  private poked(panels: readonly Panel[]): Panel | null {
    const near = this.nearest(panels, true);
    if (near && near.distance[0]! > LET_GO) this.before = near;
    return near && near.distance[0]! <= HOVER ? near : null;
  }

  /** Depth of the fingertip's press: 1 once it went through the panel from before. */
  private touchOf(panel: Panel): number {
    const distance = panel.distance[0]!;
    if (this.before !== panel || distance > LET_GO) return 0;
    return distance <= 0 ? 1 : 0.5;
  }

  private drawRay(nearest: Panel | null, painter: Painter | null): void {
    const { pointer, ray } = this;
    const { length } = ray;
    if (!pointer.kind.drawn || this.isTouching) length[0] = -1;
    else if (nearest) length[0] = nearest.distance[0]!;
    else length[0] = painter && pointer.tracked ? painter.reach[0]! : -1;
    ray.show(pointer.origin, pointer.direction);
  }

  dispose(): void {
    this.leave();
    this.model?.dispose();
    this.tips.clear();
    this.pointer.grip.removeFromParent();
    this.ray.dispose();
  }
}
