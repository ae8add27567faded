/** The hand that paints: its strokes and their haptics. */
import type { PointerSample } from '../../store/types';
import { Vector3, type Object3D } from 'three';
import { actions } from '../../store/actions';
import type { Engine } from '../../engine/engine';
import { acceptPeople } from '../../engine/find-people';
import type { Brush, StrokeResult } from '../../protocol/messages';
import { peek } from '../../store/watch';
import { canEdit, isStroke, notify, state } from '../../store/state';
import { brushFor, refusal } from '../../tools/brush';
import type { Stroke } from '../../tools/strokes';
import { completes, roomWay, wayOf, type Way } from '../../tools/ways';
import { AirShape } from './air';
import { PreviewRequests } from './asking';
import { BrushLook } from './brush-look';
import { Completion } from './completion';
import { BUMP, ChangeCounter, LEVEL_TICK, PAINT_MS, strengthOf } from '../input/haptics';
import type { Place } from './place';
import { Pointing } from './pointing';
import type { Pointer } from '../input/pointer';
import type { Level } from '../input/pressure';

/** A sample each time the tip has moved by this part of the radius. */
const SAMPLE_STEP = 0.15;
const RAY_EVERY_MS = 16;
/** A far pointer looks for the surface so often, and finds points that are so near to its ray. */
const DEPTH_EVERY_MS = 60;
const DEPTH_RADIUS = 0.03;

const GUESSED = 'Its position is only estimated. Move it into view of the headset and press again.';

type Triple = [number, number, number];

export class Painter {
  /** The sphere's middle, in the scene. */
  readonly tip = new Vector3();
  /** The sphere's radius now, metres of the recording. */
  private readonly radius = new Float64Array(1);
  private readonly look: BrushLook;
  private readonly air: AirShape;
  private stroke: Stroke | null = null;
  private way: Way = wayOf('sphere');
  private level: Level = 0;
  /** The trigger went down to point at something once, and is not up again. */
  private points = false;
  /** The press is not one that a panel or the room had first. */
  private free = false;
  /** The frame that the stroke began in, as asked for and as shown. */
  private readonly begunIn = { requested: -1, shown: -1 };
  private readonly counter = new ChangeCounter();
  private readonly mine = new Set<string>();
  private readonly local = new Vector3();
  private readonly aim = new Vector3();
  private lastDepth = 0;
  private pressedAt = 0;
  /** `local` and `aim` in the words of strokes. */
  private readonly sample: { origin: Triple; direction: Triple } = {
    origin: [0, 0, 0],
    direction: [0, 0, -1],
  };
  private readonly last = new Vector3();
  private lastRay = 0;
  readonly completion: Completion;
  private readonly previewRequests: PreviewRequests;
  private readonly pointing: Pointing;
  private readonly unsubscribeHaptics: () => void;

  constructor(
    private readonly engine: Engine,
    private readonly place: Place,
    private readonly pulse: (strength: number, milliseconds: number) => void,
  ) {
    this.look = new BrushLook(engine, place);
    this.air = new AirShape(engine.viewer, place);
    this.pointing = new Pointing(engine, place, this.look, pulse);
    this.previewRequests = new PreviewRequests(engine);
    this.completion = new Completion(engine.objects);
    this.unsubscribeHaptics = engine.strokes.results.add(this.onResult);
  }

  addTo(scene: Object3D): void {
    scene.add(this.look.sphere, this.air.line.mesh);
  }

  dispose(): void {
    this.finish();
    this.previewRequests.dispose();
    this.completion.dispose();
    this.unsubscribeHaptics();
    this.look.dispose();
    this.air.dispose();
  }

  /** Pulse by the number of newly changed points in the server's result. */
  private readonly onResult = (result: StrokeResult): void => {
    if (!this.mine.has(result.id)) return;
    const strength = strengthOf(this.counter.take(result));
    if (strength > 0) this.pulse(strength, PAINT_MS);
    if (result.final) this.mine.delete(result.id);
  };

  get painting(): boolean {
    return this.level > 0;
  }

  /** Let the brush glow for a moment. */
  glow(): void {
    this.look.glow();
  }

  /** Metres of ray to show, or −1. */
  get reach(): Float64Array {
    return this.look.reach;
  }

  /** Once per frame. `blocked`: the trigger is for something else (a panel). */
  update(
    hand: Pointer | null,
    other: Pointer | null,
    head: Vector3,
    blocked: boolean,
    now: number,
  ): void {
    if (hand?.tracked !== true || peek(state.sequence) === null) {
      this.interrupt(hand);
      // Look and pinch come pressed; every other input must be let go before its press counts.
      this.free = hand?.tracked !== true;
      this.rest();
      return;
    }
    this.checkPress(hand, other, blocked);
    const level = hand.pressure.update(this.free ? hand.trigger : 0, now);
    this.measureSphere();
    this.aimTip(hand, level, now);
    if (level !== this.level) this.turnTo(level, hand, head, now);
    const way = this.painting ? this.way : roomWay();
    if (this.painting) this.continueStroke(hand, other, now);
    else this.updatePreview(!blocked, way, hand, now);
    const color = this.look.show(!blocked, way, hand, this.tip, this.radius, now);
    if (color !== null) this.air.line.paint(color);
  }

  /** End a stroke that cannot continue, and track whether the press may paint. */
  private checkPress(hand: Pointer, other: Pointer | null, blocked: boolean): void {
    if (this.moved()) this.interrupt(hand);
    if (hand.trigger === 0) this.free = true;
    else if (blocked && !this.painting) this.free = false;
    if (this.free && this.guesses(hand, other)) this.refuse(hand);
  }

  /** Whether the place of the brush, or of a box's other corner, is guessed. */
  private guesses(hand: Pointer, other: Pointer | null): boolean {
    const box = this.painting && this.way.name === 'box';
    return hand.guessed || (box && other?.guessed === true);
  }

  /** Refuse an estimated pose: the stroke ends, and the press is ignored until its release. */
  private refuse(hand: Pointer): void {
    this.interrupt(hand);
    hand.disarm();
    notify('info', 'Not painted: out of view of the headset', GUESSED);
  }

  /** Hide the brush without a hand that paints. */
  private rest(): void {
    this.previewRequests.leave();
    this.look.hide();
  }

  /** Show a preview of the selection of a press. */
  private updatePreview(canPreview: boolean, way: Way, hand: Pointer, now: number): void {
    if (!canPreview || !isStroke(peek(state.tool))) {
      this.previewRequests.leave();
      return;
    }
    if (way.preview === 'asked') this.aimAt(way, hand);
    this.previewRequests.update(way, this.pointed(), now);
  }

  /** A push up (1) or down (−1) while the trigger is held: the object under the stroke, or its levels. */
  stepLevel(steps: number): void {
    if (!this.painting || this.points) return;
    const before = peek(state.object)?.level;
    const { stroke, completion } = this;
    if (this.way.samples === 'clicks') actions.tools.stepObject(steps);
    else if (completion.held) completion.step(steps);
    else if (stroke && steps > 0 && completes(this.way)) {
      stroke.end();
      this.stroke = null;
      completion.hold(stroke.id);
    }
    if (peek(state.object)?.level !== before)
      this.pulse(LEVEL_TICK.strength, LEVEL_TICK.milliseconds);
  }

  /** Put the ray that a press of `way` sends into `local` and `aim`. */
  private aimAt(way: Way, hand: Pointer): void {
    const { place, local, aim } = this;
    place.directionToLocal(hand.direction, aim);
    place.toLocal(way.far ? hand.origin : this.tip, local);
    // From outside of the sphere inwards, so that the nearest surface is met.
    if (!way.far) local.addScaledVector(aim, -this.radius[0]!);
  }

  private noteFrame(): void {
    this.begunIn.requested = peek(state.frame);
    this.begunIn.shown = peek(state.shown).frame;
  }

  /** Whether the shown frame, or the permission to paint, changed since the start of the stroke. */
  private moved(): boolean {
    const { requested, shown } = this.begunIn;
    if (!this.painting) return false;
    const isSameFrame = peek(state.frame) === requested && peek(state.shown).frame === shown;
    return !isSameFrame || !peek(canEdit);
  }

  /** End the stroke, discard air drawing, and ignore the press until its release. */
  interrupt(hand: Pointer | null): void {
    if (!this.painting) return;
    this.finish();
    hand?.disarm();
  }

  /**
   * The stroke is given up if it began within so many milliseconds: its press was half of a gesture of
   * two hands, or the system's.  Returns whether it was.
   */
  withdraw(now: number, milliseconds: number): boolean {
    if (!this.painting || now - this.pressedAt > milliseconds) return false;
    this.stroke?.cancel();
    this.stroke = null;
    this.finish();
    this.free = false;
    return true;
  }

  private measureSphere(): void {
    const { radius } = peek(state.brush);
    this.radius[0] = this.level === 0.5 ? radius * 0.5 : radius;
  }

  /** Place the brush: at the pinch, before a controller, or along the ray where that hits. */
  private aimTip(hand: Pointer, level: Level, now: number): void {
    if (hand.reach === 'far') {
      if (this.level === 0) this.findDepth(hand, level > 0, now);
      hand.along(this.tip);
      return;
    }
    if (hand.hasPinch) {
      this.tip.copy(hand.pinch);
      return;
    }
    const { tip, place } = this;
    const { origin, direction } = hand;
    const size = Math.min(0.3, peek(state.brush).radius * place.scale);
    const ahead = hand.tip[0]! + 0.5 * size;
    tip.x = origin.x + ahead * direction.x;
    tip.y = origin.y + ahead * direction.y;
    tip.z = origin.z + ahead * direction.z;
  }

  /** At the first surface that the ray meets; while one paints it stays that far. */
  private findDepth(hand: Pointer, pressed: boolean, now: number): void {
    if (!pressed && now - this.lastDepth < DEPTH_EVERY_MS) return;
    this.lastDepth = now;
    const hit = this.look.hit(hand, DEPTH_RADIUS);
    if (hit) hand.depth[0] = hit.distance * this.place.scale;
  }

  private turnTo(level: Level, hand: Pointer, head: Vector3, now: number): void {
    const before = this.level;
    if (level > 0 && this.completion.held) {
      this.level = level;
      return;
    }
    if (before > 0) this.finish(head);
    this.level = level;
    this.measureSphere();
    if (before === 0) this.pressedAt = now;
    if (level > 0) this.press(hand, before === 0);
  }

  /** A press begins, `first`, or goes on with another size of the brush. */
  private press(hand: Pointer, first: boolean): void {
    if (first) this.points = acceptPeople() || !isStroke(peek(state.tool));
    this.way = this.points ? wayOf('sphere') : roomWay();
    this.noteFrame();
    if (this.points) {
      if (first) this.pointing.begin(hand, this.tip);
      return;
    }
    if (first && refusal() !== null) this.pulse(BUMP.strength, BUMP.milliseconds);
    if (this.way.samples === 'drawn') this.air.begin(this.way, this.tip);
    else this.pressBrush(hand, first);
  }

  private pressBrush(hand: Pointer, first: boolean): void {
    const brush = brushFor(this.way, this.radius[0]!);
    if (this.way.samples === 'clicks') {
      this.aimAt(this.way, hand);
      if (brush && first) this.engine.objects.click(structuredClone(this.pointed()));
      return;
    }
    this.previewRequests.leave();
    this.completion.begin();
    this.stroke = brush && this.begin(brush);
    this.last.set(NaN, NaN, NaN);
  }

  private begin(brush: Brush): Stroke | null {
    const stroke = this.engine.beginStroke(brush);
    if (stroke) this.mine.add(stroke.id);
    return stroke;
  }

  private continueStroke(hand: Pointer, other: Pointer | null, now: number): void {
    if (this.pointing.move(hand, this.tip)) return;
    if (this.way.samples === 'drawn') {
      this.air.extend(this.tip, other);
      return;
    }
    if (!this.stroke || !this.aimSample(hand, now)) return;
    this.last.copy(this.local);
    const pointed = this.pointed();
    this.stroke.add(pointed, now);
    this.completion.add(pointed, this.way.far ? 0 : this.radius[0]!);
  }

  private pointed(): PointerSample {
    const { local, aim, sample } = this;
    const { origin, direction } = sample;
    origin[0] = local.x;
    origin[1] = local.y;
    origin[2] = local.z;
    direction[0] = aim.x;
    direction[1] = aim.y;
    direction[2] = aim.z;
    return sample;
  }

  /** Put the next sample into `local` and `aim`; false when none is due. */
  private aimSample(hand: Pointer, now: number): boolean {
    const { place, local, aim, last } = this;
    place.directionToLocal(hand.direction, aim);
    const once = this.way.samples === 'once';
    if (this.way.far) {
      if (!once && now - this.lastRay < RAY_EVERY_MS) return false;
      this.lastRay = now;
      place.toLocal(hand.origin, local);
      return !once || Number.isNaN(this.last.x);
    }
    if (once) {
      this.aimAt(this.way, hand);
      return Number.isNaN(this.last.x);
    }
    place.toLocal(this.tip, local);
    const x = last.x - local.x;
    const y = last.y - local.y;
    const z = last.z - local.z;
    const step = SAMPLE_STEP * this.radius[0]!;
    return !(x * x + y * y + z * z < step * step);
  }

  /** Finish the stroke and send its remaining samples. Without `eye`, air drawing is discarded. */
  finish(eye: Vector3 | null = null): void {
    const { stroke } = this;
    stroke?.end();
    this.pointing.end();
    this.stroke = null;
    if (this.completion.held) this.completion.release(eye === null);
    else if (stroke && eye && completes(this.way)) this.completion.offer(stroke.id);
    this.air.hide();
    if (this.level > 0 && this.way.samples === 'drawn' && eye) this.sendDrawn(eye);
    this.level = 0;
  }

  private sendDrawn(eye: Vector3): void {
    const info = peek(state.sequence);
    const shape = info && this.air.end(eye, info);
    const brush = shape && brushFor(this.way, this.radius[0]!);
    if (brush) this.begin({ ...brush, ...shape })?.end();
  }
}
