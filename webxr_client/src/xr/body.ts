/** What one sees of a hand: its model, its ray, its tips; and the panel that it points at. */
import type { Matrix4, Object3D } from 'three';
import type { Hand } from './hand';
import { BUTTON_TICK } from './haptics';
import { controllerModel, disposeModel, HandModel, Ray } from './model';
import type { Painter } from './painter';
import type { Panel } from './panel';
import type { Lessons } from './lessons';
import { Tips } from './tips';

export class Body {
  readonly tips: Tips;
  joints: HandModel | null = null;
  /** The panel that its ray is on. */
  on: Panel | null = null;
  private readonly ray = new Ray();
  private model: Object3D | null = null;

  constructor(
    readonly hand: Hand,
    lessons: Lessons,
  ) {
    this.tips = new Tips(lessons, hand);
  }

  addTo(scene: Object3D, rig: Object3D): void {
    rig.add(this.hand.grip);
    scene.add(this.ray.line);
  }

  /** A controller or hand has come. */
  dress(source: XRInputSource, paints: boolean, rig: Object3D): void {
    this.strip();
    this.hand.attach(source);
    if (source.hand) {
      this.joints = new HandModel(source.hand);
      rig.add(this.joints.mesh);
    } else {
      this.model = controllerModel(this.hand.device!);
      this.hand.grip.add(this.model);
    }
    this.explain(paints);
  }

  /** A bare hand's joints; `rig` is where the headset's space lies in the scene. */
  follow(frame: XRFrame, space: XRReferenceSpace, rig: Matrix4): void {
    const { hand, joints } = this;
    joints?.update(frame, space);
    hand.hasPinch = joints?.pinch(hand.pinch) ?? false;
    if (hand.hasPinch) hand.pinch.applyMatrix4(rig);
  }

  explain(paints: boolean): void {
    this.tips.set(paints);
  }

  /** It has gone. */
  strip(): void {
    if (this.model) disposeModel(this.model);
    this.joints?.dispose();
    this.model = this.joints = null;
    this.tips.clear();
    this.hand.detach();
  }

  /** Let the ray meet the panels; a held one keeps it. `painter`: what this hand paints with. */
  point(panels: readonly Panel[], painter: Painter | null): void {
    const { hand } = this;
    const held = this.on?.held ? this.on : null;
    const { length } = this.ray;
    let nearest: Panel | null = null;
    const free = hand.tracked && !painter?.painting;
    for (let i = 0; i < panels.length; i++) {
      const panel = panels[i]!;
      if (!free || (held && panel !== held)) continue;
      if (!panel.meet(hand.origin, hand.direction)) continue;
      if (nearest && panel.away[0]! >= nearest.away[0]!) continue;
      nearest = panel;
    }
    if (this.on && this.on !== nearest) this.on.leave();
    this.on = nearest;
    if (nearest?.point(hand.edge.click)) {
      hand.pulse(BUTTON_TICK.strength, BUTTON_TICK.milliseconds);
    }
    if (nearest) length[0] = nearest.away[0]!;
    else length[0] = painter && hand.tracked ? painter.reach[0]! : -1;
    this.ray.show(hand.origin, hand.direction);
  }

  dispose(): void {
    this.strip();
    this.ray.dispose();
  }
}
