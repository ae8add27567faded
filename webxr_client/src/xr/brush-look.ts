/** How the brush looks: the ball at the tip, the ray's length, and the points that light up. */
import { Color, Mesh, MeshBasicMaterial, SphereGeometry, Vector3 } from 'three';
import { firstHit, type Hit } from '../cloud/pick';
import type { Engine } from '../engine/engine';
import { FLOOR_SPOT } from '../engine/floor';
import { isStroke, state } from '../state';
import { brushColor, type Way } from './brush';
import type { Hand } from './hand';
import type { Place } from './place';

/** The ray looks for the surface so often. */
const EVERY_MS = 60;
const FAR = 30;
const PICK_LENGTH = 4;
const POINTER_SIZE = 0.006;

export class BrushLook {
  readonly ball: Mesh<SphereGeometry, MeshBasicMaterial>;
  /** Metres of ray to show, or −1. */
  reach = -1;
  private readonly local: [number, number, number] = [0, 0, 0];
  private readonly aim: [number, number, number] = [0, 0, 0];
  private readonly scratch = new Vector3();
  private readonly color = new Color();
  private shownColor = '';
  private last = 0;

  constructor(
    private readonly engine: Engine,
    private readonly place: Place,
  ) {
    const material = new MeshBasicMaterial({ transparent: true, opacity: 0.28, depthWrite: false });
    this.ball = new Mesh(new SphereGeometry(1, 32, 20), material);
    this.ball.renderOrder = 95;
    this.ball.frustumCulled = false;
  }

  /** Once per frame; `radius` in metres of the recording. Returns the colour when it is new. */
  show(
    visible: boolean,
    way: Way,
    hand: Hand,
    tip: Vector3,
    radius: number,
    now: number,
  ): string | null {
    const { uniforms } = this.engine.viewer;
    const tool = state.tool.peek();
    const floor = tool === 'floor';
    const brushes = visible && (floor || isStroke(tool));
    const drawn = !floor && (way === 'lasso' || way === 'box');
    const far = floor || way === 'ray' || way === 'plane';
    this.ball.visible = brushes && !far;
    this.ball.position.copy(tip);
    this.ball.scale.setScalar(drawn ? POINTER_SIZE : radius * this.place.scale);
    if (!brushes || drawn) {
      uniforms.brushMode.value = 0;
      this.reach = visible && tool === 'pick' ? PICK_LENGTH : -1;
      return this.newColor();
    }
    uniforms.brushOnlyUnlabeled.value =
      tool === 'paint' && state.brush.peek().onlyUnlabeled ? 1 : 0;
    const through = !floor && way === 'ray' && state.brush.peek().through;
    if (far) this.followRay(hand, floor ? FLOOR_SPOT : radius, now, through);
    else {
      this.reach = -1;
      uniforms.brushMode.value = 1;
      uniforms.brushRadius.value = radius;
      this.place.toLocal(tip, uniforms.brushA.value);
      uniforms.brushB.value.copy(uniforms.brushA.value);
    }
    return this.newColor();
  }

  private followRay(hand: Hand, radius: number, now: number, through: boolean): void {
    const { uniforms } = this.engine.viewer;
    uniforms.brushRadius.value = radius;
    if (through) {
      this.reach = FAR;
      uniforms.brushMode.value = 2;
      this.place.toLocal(hand.origin, uniforms.brushA.value);
      this.place.directionToLocal(hand.direction, uniforms.brushB.value);
      return;
    }
    if (now - this.last < EVERY_MS) return;
    this.last = now;
    const hit = this.hit(hand, radius);
    this.reach = hit ? hit.distance * this.place.scale : FAR;
    uniforms.brushMode.value = hit ? 1 : 0;
    if (!hit) return;
    uniforms.brushA.value.fromArray(hit.position);
    uniforms.brushB.value.fromArray(hit.position);
  }

  /** What the hand's ray meets first. */
  hit(hand: Hand, radius: number): Hit | null {
    const frame = this.engine.playback.frame;
    if (!frame) return null;
    const { local, aim, place, scratch } = this;
    place.toLocal(hand.origin, scratch).toArray(local);
    place.directionToLocal(hand.direction, scratch).toArray(aim);
    return firstHit(frame, local, aim, radius);
  }

  private newColor(): string | null {
    const color = brushColor();
    if (color === this.shownColor) return null;
    this.shownColor = color;
    this.ball.material.color.set(color);
    const { r, g, b } = this.color.set(color).convertLinearToSRGB();
    this.engine.viewer.uniforms.brushColour.value.set(r, g, b);
    return color;
  }

  dispose(): void {
    this.ball.removeFromParent();
    this.ball.geometry.dispose();
    this.ball.material.dispose();
    this.engine.viewer.uniforms.brushMode.value = 0;
  }
}
