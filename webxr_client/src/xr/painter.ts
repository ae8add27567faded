/** The hand that paints: the ball at its tip, its strokes, and what they feel like. */
import { BufferGeometry, Color, DynamicDrawUsage, Float32BufferAttribute, Line, LineBasicMaterial, Matrix4, Mesh, MeshBasicMaterial, Quaternion, SphereGeometry, Vector3, type Object3D } from 'three'; // prettier-ignore
import { actions } from '../actions';
import { DELETED } from '../cloud/frame';
import { firstHit } from '../cloud/pick';
import type { Engine } from '../engine/engine';
import { state } from '../state';
import type { Stroke } from '../tools/strokes';
import { brushColor, brushFor, currentWay, refusal, type Way } from './brush';
import type { Hand } from './hand';
import { BUMP, PAINT_MS, strengthOf, TouchCounter } from './haptics';
import { AirLasso } from './lasso';
import type { Place } from './place';
import type { Level } from './pressure';

/** A sample each time the tip has moved by this part of the radius. */
const SAMPLE_STEP = 0.15;
const RAY_EVERY_MS = 60;
const RAY_LENGTH = 30;
const LASSO_CORNERS = 4000;

export class Painter {
  /** Ball, ray and outline; a child of the scene. */
  readonly ball: Mesh<SphereGeometry, MeshBasicMaterial>;
  readonly outline: Line<BufferGeometry, LineBasicMaterial>;
  /** The ball's middle, in the scene. */
  readonly tip = new Vector3();
  /** Metres to what the ray meets, or −1. */
  reach = -1;
  private stroke: Stroke | null = null;
  private way: Way = 'ball';
  private level: Level = 0;
  private readonly lasso = new AirLasso();
  private readonly counter = new TouchCounter();
  private readonly mine = new Set<string>();
  private readonly local = new Vector3();
  private readonly aim = new Vector3();
  private readonly last = new Vector3();
  private readonly boxStart = new Vector3();
  private readonly color = new Color();
  private lastRay = 0;
  private shownColor = '';

  constructor(
    private readonly engine: Engine,
    private readonly place: Place,
    private readonly pulse: (strength: number, milliseconds: number) => void,
  ) {
    const material = new MeshBasicMaterial({ transparent: true, opacity: 0.28, depthWrite: false });
    this.ball = new Mesh(new SphereGeometry(1, 32, 20), material);
    this.ball.renderOrder = 95;
    this.ball.frustumCulled = false;
    const geometry = new BufferGeometry();
    const corners = new Float32BufferAttribute(new Float32Array(3 * LASSO_CORNERS), 3);
    corners.setUsage(DynamicDrawUsage);
    geometry.setAttribute('position', corners);
    this.outline = new Line(geometry, new LineBasicMaterial({ depthTest: false }));
    this.outline.frustumCulled = false;
    this.outline.renderOrder = 96;
    this.outline.visible = false;
    engine.strokes.results.add(this.felt);
  }

  addTo(scene: Object3D): void {
    scene.add(this.ball, this.outline);
  }

  dispose(): void {
    this.finish();
    this.engine.strokes.results.delete(this.felt);
    for (const mesh of [this.ball, this.outline]) {
      mesh.removeFromParent();
      mesh.geometry.dispose();
      mesh.material.dispose();
    }
    this.engine.viewer.uniforms.brushMode.value = 0;
  }

  /** The server counted newly touched points: that is what the hand feels. */
  private readonly felt: Parameters<Engine['strokes']['results']['add']>[0] = (result) => {
    if (!this.mine.has(result.id)) return;
    const strength = strengthOf(this.counter.take(result));
    if (strength > 0) this.pulse(strength, PAINT_MS);
    if (result.final) this.mine.delete(result.id);
  };

  get painting(): boolean {
    return this.level > 0;
  }

  /** Once per frame. `blocked`: the trigger is for something else (a panel). */
  update(hand: Hand, other: Hand, head: Vector3, blocked: boolean, now: number): void {
    const usable = hand.tracked && state.sequence.peek() !== null;
    const level = usable
      ? hand.pressure.update(blocked && !this.painting ? 0 : hand.trigger, now)
      : 0;
    this.aimTip(hand);
    if (level !== this.level) this.turnTo(level, hand, other, head);
    if (this.level > 0) this.go(hand, other, now);
    this.show(usable && !blocked, hand, now);
  }

  /** Radius now, in metres of the recording. */
  get radius(): number {
    const { radius } = state.brush.peek();
    return this.level === 0.5 ? radius * 0.5 : radius;
  }

  private aimTip(hand: Hand): void {
    const size = Math.min(0.3, state.brush.peek().radius * this.place.scale);
    const ahead = (hand.device?.tip ?? 0) + 0.5 * size;
    this.tip.copy(hand.origin).addScaledVector(hand.direction, ahead);
  }

  // ── strokes ────────────────────────────────────────────────────────────────────────────────

  private turnTo(level: Level, hand: Hand, other: Hand, head: Vector3): void {
    const before = this.level;
    if (before > 0) this.finish(other, head);
    this.level = level;
    if (level === 0) return;
    if (state.tool.peek() === 'pick') {
      this.pick(hand);
      return;
    }
    this.way = currentWay();
    if (before === 0 && refusal() !== null) this.pulse(BUMP.strength, BUMP.milliseconds);
    if (this.way === 'lasso' || this.way === 'box') {
      this.lasso.begin();
      this.boxStart.copy(this.tip);
      return;
    }
    const brush = brushFor(this.way, this.radius);
    this.stroke = brush && this.engine.beginStroke(brush);
    if (!this.stroke) return;
    this.mine.add(this.stroke.id);
    this.last.set(NaN, NaN, NaN);
  }

  private go(hand: Hand, other: Hand, now: number): void {
    if (this.way === 'lasso') {
      if (this.lasso.add(this.tip)) this.drawOutline();
      return;
    }
    if (this.way === 'box') {
      this.drawBox(other);
      return;
    }
    const { stroke, place } = this;
    if (!stroke) return;
    if (this.way === 'ball') {
      place.toLocal(this.tip, this.local);
      if (this.last.distanceTo(this.local) < SAMPLE_STEP * this.radius) return;
      place.directionToLocal(hand.direction, this.aim);
    } else if (this.way === 'ray') {
      if (now - this.lastRay < 16) return;
      this.lastRay = now;
      place.toLocal(hand.origin, this.local);
      place.directionToLocal(hand.direction, this.aim);
    } else {
      // Fill: from a little outside the ball inwards, so that the nearest surface is met.
      if (!Number.isNaN(this.last.x)) return;
      place.directionToLocal(hand.direction, this.aim);
      const far = state.brush.peek().radius;
      place.toLocal(this.tip, this.local).addScaledVector(this.aim, -far);
    }
    this.last.copy(this.local);
    stroke.add({ origin: this.local.toArray(), direction: this.aim.toArray() });
  }

  /** Let go: send what is still to be sent. */
  finish(other: Hand | null = null, head: Vector3 | null = null): void {
    this.stroke?.end();
    this.stroke = null;
    this.outline.visible = false;
    if (this.level === 0) return;
    this.level = 0;
    const info = state.sequence.peek();
    if (!info || !other || !head) return;
    if (this.way === 'lasso') {
      const drawn = this.lasso.end(head, this.place.localFromScene, info);
      if (drawn) this.send('lasso', drawn);
    }
    if (this.way === 'box') this.sendBox(other);
  }

  private send(way: Way, fields: object): void {
    const brush = brushFor(way, this.radius);
    const stroke = brush && this.engine.beginStroke({ ...brush, ...fields });
    if (!stroke) return;
    this.mine.add(stroke.id);
    stroke.end();
  }

  /** The other corner of a box: the other hand, or where this one went. */
  private boxEnd(other: Hand, out: Vector3): Vector3 {
    if (!other.tracked || other.trigger < 0.5) return out.copy(this.tip);
    return out.copy(other.origin).addScaledVector(other.direction, other.device?.tip ?? 0);
  }

  private sendBox(other: Hand): void {
    const info = state.sequence.peek()!;
    const two = other.trigger >= 0.5;
    const one = (two ? this.tip : this.boxStart).clone();
    const end = this.boxEnd(other, new Vector3());
    const world = this.engine.viewer.world;
    world.worldToLocal(one);
    world.worldToLocal(end);
    const size = end.clone().sub(one);
    const center = one.add(end).multiplyScalar(0.5);
    const localFromRoom = new Matrix4().copy(this.engine.viewer.room.matrix).invert();
    center.applyMatrix4(localFromRoom);
    const turn = new Quaternion().setFromRotationMatrix(localFromRoom);
    const [x, y, z] = info.shift;
    this.send('box', {
      center: [center.x + x, center.y + y, center.z + z],
      size: [Math.abs(size.x), Math.abs(size.y), Math.abs(size.z)].map((edge) =>
        Math.max(edge, 0.005),
      ),
      quaternion: turn.toArray(),
    });
  }

  private pick(hand: Hand): void {
    const label = this.labelAt(hand);
    if (label === 0 || label === DELETED) return;
    actions.selectLabel(label);
    actions.setTool('paint');
    this.pulse(0.5, 30);
  }

  /** The label of the point that the ray meets first. */
  private labelAt(hand: Hand): number {
    const frame = this.engine.playback.frame;
    if (!frame) return 0;
    this.place.toLocal(hand.origin, this.local);
    this.place.directionToLocal(hand.direction, this.aim);
    const hit = firstHit(frame, this.local.toArray(), this.aim.toArray(), 0.03);
    return hit ? frame.labelOf(hit.point) : 0;
  }

  // ── what is seen ───────────────────────────────────────────────────────────────────────────

  private show(visible: boolean, hand: Hand, now: number): void {
    const { uniforms } = this.engine.viewer;
    const way = this.level > 0 ? this.way : currentWay();
    const tool = state.tool.peek();
    const ball = visible && tool !== 'navigate' && tool !== 'pick' && way !== 'ray';
    this.ball.visible = ball;
    this.takeColor();
    const size = way === 'lasso' || way === 'box' ? 0.006 : this.radius * this.place.scale;
    this.ball.position.copy(this.tip);
    this.ball.scale.setScalar(size);
    const lights = visible && tool !== 'navigate' && tool !== 'pick';
    if (!lights || way === 'lasso' || way === 'box') {
      uniforms.brushMode.value = 0;
      this.reach = way === 'ray' || tool === 'pick' ? this.reach : -1;
      return;
    }
    uniforms.brushRadius.value = this.radius;
    uniforms.brushOnlyUnlabeled.value =
      tool === 'paint' && state.brush.peek().onlyUnlabeled ? 1 : 0;
    if (way === 'ray') this.showRay(hand, now);
    else {
      this.reach = -1;
      uniforms.brushMode.value = 1;
      this.place.toLocal(this.tip, uniforms.brushA.value);
      uniforms.brushB.value.copy(uniforms.brushA.value);
    }
  }

  /** Where the ray meets the surface, looked for a few times a second. */
  private showRay(hand: Hand, now: number): void {
    const { uniforms } = this.engine.viewer;
    const frame = this.engine.playback.frame;
    if (state.brush.peek().through) {
      this.reach = RAY_LENGTH;
      uniforms.brushMode.value = 2;
      this.place.toLocal(hand.origin, uniforms.brushA.value);
      this.place.directionToLocal(hand.direction, uniforms.brushB.value);
      return;
    }
    if (!frame || now - this.lastRay < RAY_EVERY_MS) return;
    this.lastRay = now;
    this.place.toLocal(hand.origin, this.local);
    this.place.directionToLocal(hand.direction, this.aim);
    const hit = firstHit(frame, this.local.toArray(), this.aim.toArray(), this.radius);
    this.reach = hit ? hit.distance * this.place.scale : -1;
    uniforms.brushMode.value = hit ? 1 : 0;
    if (!hit) return;
    uniforms.brushA.value.fromArray(hit.position);
    uniforms.brushB.value.fromArray(hit.position);
  }

  private takeColor(): void {
    const color = brushColor();
    if (color === this.shownColor) return;
    this.shownColor = color;
    this.ball.material.color.set(color);
    this.outline.material.color.set(color);
    this.color.set(color).convertLinearToSRGB();
    this.engine.viewer.uniforms.brushColour.value.set(this.color.r, this.color.g, this.color.b);
  }

  private drawOutline(): void {
    const { corners } = this.lasso;
    const attribute = this.outline.geometry.getAttribute('position');
    const end = corners.length / 3 - 1;
    if (end >= LASSO_CORNERS) return;
    attribute.setXYZ(end, this.tip.x, this.tip.y, this.tip.z);
    attribute.needsUpdate = true;
    this.outline.geometry.setDrawRange(0, end + 1);
    this.outline.visible = true;
  }

  /** Twelve edges as one line: up one face, and round the other. */
  private drawBox(other: Hand): void {
    const two = other.trigger >= 0.5;
    const from = two ? this.tip : this.boxStart;
    const to = this.boxEnd(other, this.local);
    const attribute = this.outline.geometry.getAttribute('position');
    for (let i = 0; i < BOX_PATH.length; i++) {
      const corner = BOX_PATH[i]!;
      attribute.setXYZ(
        i,
        corner & 1 ? to.x : from.x,
        corner & 2 ? to.y : from.y,
        corner & 4 ? to.z : from.z,
      );
    }
    attribute.needsUpdate = true;
    this.outline.geometry.setDrawRange(0, BOX_PATH.length);
    this.outline.visible = true;
  }
}

const BOX_PATH = [0, 1, 3, 2, 0, 4, 5, 1, 5, 7, 3, 7, 6, 2, 6, 4] as const;
