/** Look of the brush: the sphere at the tip, the ray's length, and the points that light up. */
import { free } from '../../common/free';
import { Color, Mesh, MeshBasicMaterial, SphereGeometry, Vector3 } from 'three';
import { clipMatrix } from '../../tools/clip';
import { firstHit, type Hit } from '../../cloud/points/pick';
import type { Engine } from '../../engine/engine';
import { FLOOR_SPOT } from '../../engine/floor';
import { peek } from '../../store/watch';
import { isStroke, state, type Tool } from '../../store/state';
import { brushColor } from '../../tools/brush';
import type { Way } from '../../tools/ways';
import { seenIn, type Seen } from '../../tools/seen';
import type { Place } from './place';
import type { Pointer } from '../input/pointer';
import { tint } from '../drawing/tint';

/** The ray looks for the surface so often. */
const EVERY_MS = 60;
const FAR = 30;
const PICK_LENGTH = 4;
const POINTER_SIZE = 0.006;
const OPACITY = 0.28;
/**
 * Times brighter the sphere is while it glows, and for how long, milliseconds: cues that follow each
 * other keep it alight instead of letting it flicker.
 */
const GLOW = 2.4;
const GLOW_MS = 300;

export class BrushLook {
  readonly sphere: Mesh<SphereGeometry, MeshBasicMaterial>;
  /** Metres of ray to show, or −1. */
  readonly reach = Float64Array.of(-1);
  private readonly local: [number, number, number] = [0, 0, 0];
  private readonly aim: [number, number, number] = [0, 0, 0];
  private readonly scratch = new Vector3();
  private readonly way = new Vector3();
  private readonly color = new Color();
  private shownColor = '';
  private last = 0;
  private glowsUntil = 0;
  private readonly seen: Seen;

  constructor(
    private readonly engine: Engine,
    private readonly place: Place,
  ) {
    this.seen = seenIn(engine.viewer.palette);
    const look = { vertexColors: true, transparent: true, depthWrite: false };
    this.sphere = new Mesh(new SphereGeometry(1, 32, 20), new MeshBasicMaterial(look));
    this.sphere.renderOrder = 95;
    this.sphere.frustumCulled = false;
  }

  /** Once per frame; `radius` in metres of the recording. Returns the colour when it is new. */
  show(
    visible: boolean,
    way: Way,
    hand: Pointer,
    tip: Vector3,
    radius: Float64Array,
    now: number,
  ): string | null {
    const { uniforms } = this.engine.viewer;
    const tool = peek(state.tool);
    const floor = tool === 'floor';
    const boxes = tool === 'boxes';
    const brushes = visible && hasTip(tool);
    const drawn = boxes || (!floor && way.samples === 'drawn');
    const far = floor || (!boxes && way.far);
    this.sphere.visible = brushes && !far;
    this.sphere.position.copy(tip);
    this.sphere.material.opacity = now < this.glowsUntil ? GLOW : 1;
    const { scale } = this.sphere;
    scale.x = scale.y = scale.z = drawn ? POINTER_SIZE : radius[0]! * this.place.scale;
    if (!brushes || drawn) {
      uniforms.lightNothing();
      this.reach[0] = visible && (tool === 'pick' || boxes) ? PICK_LENGTH : -1;
      return this.newColor();
    }
    uniforms.setOnlyUnlabeled(tool === 'paint' && peek(state.brush).onlyUnlabeled);
    const through = !floor && way.through && peek(state.brush).through;
    if (far) this.followRay(hand, floor ? FLOOR_SPOT : radius[0]!, now, through);
    else {
      this.reach[0] = -1;
      uniforms.lightBall(this.place.toLocal(tip, this.scratch), radius[0]!);
    }
    return this.newColor();
  }

  /** Glow for a moment: something happened that no hand can feel. */
  glow(): void {
    this.glowsUntil = performance.now() + GLOW_MS;
  }

  /** Nothing points. */
  hide(): void {
    this.sphere.visible = false;
    this.reach[0] = -1;
    this.engine.viewer.uniforms.lightNothing();
  }

  private followRay(hand: Pointer, radius: number, now: number, through: boolean): void {
    const { uniforms } = this.engine.viewer;
    const { place, scratch, way } = this;
    if (through) {
      this.reach[0] = FAR;
      place.toLocal(hand.origin, scratch);
      uniforms.lightRay(scratch, place.directionToLocal(hand.direction, way), radius);
      return;
    }
    if (now - this.last < EVERY_MS) return;
    this.last = now;
    const hit = this.hit(hand, radius);
    this.reach[0] = hit ? hit.distance * place.scale : FAR;
    if (hit) uniforms.lightBall(scratch.fromArray(hit.position), radius);
    else uniforms.lightNothing();
  }

  /** Return the first hit of the hand's ray. */
  hit(hand: Pointer, radius: number): Hit | null {
    const frame = this.engine.playback.frame;
    if (!frame) return null;
    const { local, aim, place, scratch } = this;
    place.toLocal(hand.origin, scratch).toArray(local);
    place.directionToLocal(hand.direction, scratch).toArray(aim);
    return firstHit(frame, local, aim, radius, this.seen, peek(clipMatrix));
  }

  private newColor(): string | null {
    const color = brushColor();
    if (color === this.shownColor) return null;
    this.shownColor = color;
    tint(this.sphere.geometry, color, OPACITY);
    this.engine.viewer.uniforms.setBrushColour(this.color.set(color).convertLinearToSRGB());
    return color;
  }

  dispose(): void {
    free(this.sphere);
    this.engine.viewer.uniforms.lightNothing();
  }
}

/** Whether a tool has its own tip, or highlights its target. */
function hasTip(tool: Tool): boolean {
  return tool === 'floor' || tool === 'boxes' || isStroke(tool);
}
