/** All pointers: their arrival and departure, roles, and the targets of their rays. */
import { limits } from '../../store/limits';
import { peek } from '../../store/watch';
import { Body } from './body';
import { Handover, isOf } from './handover';
import { kindOf, KINDS, unknownInput } from '../input/kinds';
import type { Painter } from '../painting/painter';
import type { Panel } from '../panels/panel';
import { Pointer } from '../input/pointer';
import { Poses } from '../input/poses';
import type { Rig } from '../moving/rig';
import { rolesOf, type Roles } from '../input/roles';
import { xrSettings, type Side } from '../../store/xr-settings';
import { tipsFor, type Lesson, type Lessons, type Part } from '../input/lessons';
import type { Object3D } from 'three';

/** Seconds after which a controller out of the headset's sight, or gone, is missed. */
const MISSED = 1;
/** Seconds of a session after which it is told that nothing points: hands and controllers wake in the first. */
const NO_INPUT_SECONDS = 2;
/** Seconds from one look for inputs that came or went without an event to the next. */
const LOOK = 1;
const SWITCH_ON = 'press its system button to switch it on';
const SHOW = 'hold it in front of the headset';

/** A controller that has gone, and may be back in a moment: system menus take all of them. */
interface LostController {
  readonly name: string;
  readonly side: Side | 'none';
  /** Seconds since, while the session is visible. */
  readonly seconds: Float64Array;
}
const NO_ROLES: Roles<Pointer> = { brush: null, other: null, palette: null };

/** Sources that are tracked and do not press: a controller beside the hand that laid it down. */
type Session = XRSession & { readonly trackedSources?: Iterable<XRInputSource> };

export interface Changes {
  /** The brush has changed to another pointer, or to none. */
  brushGone(): void;
  /** Show a message. */
  showMessage(text: string): void;
}

export class Pointers {
  readonly bodies: Body[] = [];
  private roles = NO_ROLES;
  private readonly lostControllers: LostController[] = [];
  /** Seconds for which nothing has pointed since the session began; NaN once something did. */
  private readonly awaited = new Float64Array(1);
  private readonly looked = new Float64Array(1);
  /** Inputs that no pointer was made for. */
  private readonly refused = new WeakSet<XRInputSource>();
  private readonly undo: (() => void)[] = [];
  private readonly handover = new Handover();
  /** The sign that another hand paints, as long as it does. */
  private standIn = '';

  constructor(
    private readonly session: Session,
    private readonly poses: Poses,
    private readonly rig: Rig,
    private readonly scene: Object3D,
    private readonly lessons: Lessons,
    private readonly changes: Changes,
  ) {}

  /** Paints. */
  get brush(): Pointer | null {
    return this.roles.brush;
  }

  get brushBody(): Body | null {
    return this.brush && this.bodyOf(this.brush);
  }

  /** Goes and turns, takes hold of the room, presses the other buttons. */
  get other(): Pointer | null {
    return this.roles.other;
  }

  /** Holds the palette. */
  get palette(): Pointer | null {
    return this.roles.palette;
  }

  /** The input held on a side; null: nothing. */
  of(side: Side): Pointer | null {
    for (let i = 0; i < this.bodies.length; i++) {
      const { pointer } = this.bodies[i]!;
      if (pointer.side === side && pointer.holds) return pointer;
    }
    return null;
  }

  bodyOf(pointer: Pointer): Body {
    for (let i = 0; i < this.bodies.length; i++) {
      if (this.bodies[i]!.pointer === pointer) return this.bodies[i]!;
    }
    throw new Error('A pointer that is not there.');
  }

  listen(): void {
    const { session } = this;
    const on = (type: string, run: (event: never) => void): void => {
      session.addEventListener(type, run as EventListener);
      this.undo.push(() => session.removeEventListener(type, run as EventListener));
    };
    on('inputsourceschange', ({ added, removed }: XRInputSourcesChangeEvent) =>
      this.sources(added, removed, true),
    );
    on('trackedsourceschange', ({ added, removed }: XRInputSourcesChangeEvent) =>
      this.sources(added, removed, false),
    );
    on('selectstart', ({ inputSource }: XRInputSourceEvent) => this.select(inputSource, true));
    on('selectend', ({ inputSource }: XRInputSourceEvent) => this.select(inputSource, false));
    on('visibilitychange', () => {
      if (session.visibilityState !== 'visible') this.disarm();
    });
    this.sources([...session.inputSources], [], true);
    this.sources([...(session.trackedSources ?? [])], [], false);
  }

  /** Some browsers tell of a press before they tell of its source. */
  private select(source: XRInputSource, down: boolean): void {
    if (down && !this.bodyFor(source)) this.sources([source], [], true);
    this.bodyFor(source)?.pointer.select(down);
  }

  private bodyFor(source: XRInputSource, primary = true): Body | undefined {
    const is = ({ pointer }: Body): boolean =>
      pointer.source === source && pointer.primary === primary && !pointer.leaving;
    return this.bodies.find(is);
  }

  private sources(
    added: readonly XRInputSource[],
    removed: readonly XRInputSource[],
    primary: boolean,
  ): void {
    for (const source of removed) this.removeSource(source, primary);
    for (const source of added) this.addSource(source, primary);
    this.assign();
  }

  private addSource(source: XRInputSource, primary: boolean): void {
    if (this.bodyFor(source, primary)) return;
    const kind = kindOf(source);
    const input = kind ? this.poses.add(source) : -1;
    if (!kind) this.changes.showMessage(unknownInput(source));
    if (!kind || input < 0) {
      this.refused.add(source);
      return;
    }
    const pointer = new Pointer(source, kind, KINDS.indexOf(kind), primary, input);
    this.bodies.push(new Body(pointer, this.lessons, this.scene, this.rig.group));
  }

  private removeSource(source: XRInputSource, primary: boolean): void {
    const body = this.bodyFor(source, primary);
    if (!body) return;
    const { pointer } = body;
    this.poses.remove(pointer.input);
    pointer.leaving = true;
    pointer.select(false);
    // The end of a press that comes and goes with its source is seen in the next picture.
    if (pointer.momentary) return;
    this.drop(body);
    const { name, fleeting } = pointer.kind;
    if (fleeting) return;
    this.lostControllers.push({
      name: nameOf(pointer, name),
      side: pointer.side,
      seconds: new Float64Array(1),
    });
  }

  private drop(body: Body): void {
    this.bodies.splice(this.bodies.indexOf(body), 1);
    body.dispose();
  }

  /** Assign the brush and the palette to the present pointers. */
  assign(): void {
    const before = this.roles;
    const pointers = this.bodies.map(({ pointer }) => pointer);
    const { hand } = peek(xrSettings);
    this.roles = this.handover.roles(before, rolesOf(pointers, hand), hand);
    if (before.brush !== this.brush) {
      this.changes.brushGone();
      this.signHand(hand);
      // An input that came just now in order to press is meant; one held before is not.
      if (this.brush && !this.brush.momentary) this.brush.disarm();
    }
    for (const body of this.bodies) body.explain(this.partOf(body.pointer));
  }

  /** Say that the other hand paints, and that the wished one does again. */
  private signHand(wished: Side): void {
    const { brush } = this;
    if (!brush) return;
    const before = this.standIn;
    const name = nameOf(brush, brush.kind.name);
    this.standIn = isOf(wished, brush) ? '' : `The ${name} paints now`;
    if (this.standIn !== before)
      this.changes.showMessage(this.standIn || `The ${name} paints again`);
  }

  /** Let the hands change as soon as they may. */
  private hand(seconds: Float64Array): void {
    const { hand } = peek(xrSettings);
    let isPresent = false;
    for (let i = 0; i < this.bodies.length; i++) {
      const { pointer } = this.bodies[i]!;
      isPresent ||= pointer.primary && isOf(hand, pointer);
    }
    if (this.handover.update(isPresent, this.brush, seconds)) this.assign();
  }

  /** Task of a pointer. */
  partOf(pointer: Pointer): Part {
    return pointer === this.brush ? 'brush' : 'other';
  }

  /** The control that does something, and the hand that has it; null: none does. */
  hint(lesson: Lesson): string | null {
    for (const hand of [this.brush, this.other]) {
      if (!hand?.holds) continue;
      const tips = tipsFor(hand.device, this.partOf(hand), hand.side === 'left');
      const tip = tips.find((each) => each.lesson === lesson);
      if (tip) return hand === this.other ? `Other hand, ${tip.text}` : tip.text;
    }
    return null;
  }

  /** Nothing is pressed until it was seen released: one jumped, or the system was in between. */
  disarm(): void {
    for (let i = 0; i < this.bodies.length; i++) this.bodies[i]!.pointer.disarm();
  }

  update(frame: XRFrame, space: XRReferenceSpace, seconds: Float64Array): void {
    const { matrixWorld } = this.rig.group;
    this.sweep();
    for (let i = 0; i < this.bodies.length; i++) {
      const body = this.bodies[i]!;
      body.pointer.update(this.poses, matrixWorld, this.rig);
      body.pointer.judge(this.poses, frame, space);
      body.follow(frame, space, matrixWorld);
      this.miss(body, seconds);
    }
    if (this.session.visibilityState !== 'visible') return;
    this.look(seconds);
    this.hand(seconds);
    this.missGone(seconds);
    this.missAll(seconds);
  }

  /** Find inputs that came or went without an event: some browsers send none. */
  private look(seconds: Float64Array): void {
    const { looked } = this;
    looked[0] = looked[0]! + seconds[0]!;
    if (looked[0] < LOOK) return;
    looked[0] = 0;
    const sources = [...this.session.inputSources];
    const is = ({ pointer }: Body): boolean => pointer.primary && !pointer.leaving;
    const known = this.bodies.filter(is).map(({ pointer }) => pointer);
    const lost = known.filter(({ source, momentary }) => !momentary && !sources.includes(source));
    const added = sources.filter((source) => !this.bodyFor(source) && !this.refused.has(source));
    const left = lost.map(({ source }) => source);
    if (added.length + left.length > 0) this.sources(added, left, true);
  }

  /** Say once that nothing has come that points. */
  private missAll(seconds: Float64Array): void {
    const { awaited } = this;
    if (this.bodies.length > 0) awaited[0] = NaN;
    const before = awaited[0]!;
    awaited[0] = before + seconds[0]!;
    if (before >= NO_INPUT_SECONDS || !(awaited[0] >= NO_INPUT_SECONDS)) return;
    this.changes.showMessage(firstWords(this.session, peek(xrSettings).hands));
  }

  /** Say that a controller has gone, unless it or a hand in its place was there again in a moment. */
  private missGone(seconds: Float64Array): void {
    for (let i = this.lostControllers.length - 1; i >= 0; i--) {
      const { name, side, seconds: since } = this.lostControllers[i]!;
      since[0] = since[0]! + seconds[0]!;
      const back = side !== 'none' && this.of(side) !== null;
      if (!back && since[0] < MISSED) continue;
      this.lostControllers.splice(i, 1);
      const meanwhile = this.standIn && `\n${this.standIn}`;
      if (!back) this.changes.showMessage(`The ${name} is disconnected:\n${SWITCH_ON}${meanwhile}`);
    }
  }

  /** Remove departed pointers after the end of their press was handled. */
  private sweep(): void {
    for (let i = this.bodies.length - 1; i >= 0; i--) {
      const body = this.bodies[i]!;
      if (!body.pointer.leaving || !body.pointer.done) continue;
      this.drop(body);
      this.assign();
    }
  }

  /** Say once that a controller is out of sight; bare hands come and go. */
  private miss({ pointer, unseen }: Body, seconds: Float64Array): void {
    if (pointer.tracked || pointer.kind.fleeting) {
      unseen[0] = 0;
      return;
    }
    const missed = unseen[0]! >= MISSED;
    unseen[0] = unseen[0]! + seconds[0]!;
    if (missed || unseen[0] < MISSED) return;
    this.changes.showMessage(
      `The headset does not see the ${nameOf(pointer, pointer.kind.name)}:\n${SHOW}`,
    );
  }

  /**
   * Show hints for functions of buttons that are not learnt yet.  There are none for a pointer on a
   * panel, during a stroke, and in front of a panel.
   */
  teach(seconds: Float64Array, painting: boolean, panels: readonly Panel[]): void {
    const tips = peek(xrSettings).tips && (peek(limits)?.hints ?? true);
    for (let i = 0; i < this.bodies.length; i++) {
      const body = this.bodies[i]!;
      body.tips.update(seconds, tips && !painting && body.on === null, this.rig, panels);
    }
  }

  /** `far`: panels that the hand with the palette can point at as well. */
  point(panels: readonly Panel[], far: readonly Panel[], painter: Painter): void {
    for (let i = 0; i < this.bodies.length; i++) {
      const body = this.bodies[i]!;
      const { pointer } = body;
      body.point(this.carries(pointer) ? far : panels, pointer === this.brush ? painter : null);
    }
  }

  /** The pointer that is on a panel; the hand that holds the palette rests, and means none unless it presses. */
  readonly at = (panel: Panel): Pointer | null => {
    for (let i = 0; i < this.bodies.length; i++) {
      const { on, pointer } = this.bodies[i]!;
      if (on === panel && (pointer.click.down || !this.carries(pointer))) return pointer;
    }
    return null;
  };

  /** Whether it is the hand that the palette stands over. */
  private carries(pointer: Pointer): boolean {
    const { palette } = this;
    if (pointer === palette) return true;
    return palette !== null && palette.side !== 'none' && pointer.side === palette.side;
  }

  /**
   * Whether a pointer holds the room.  Without a grip the press of the one that does not paint takes
   * hold, unless it is needed for something else; while it holds, that of the other one joins in.
   */
  holds(pointer: Pointer | null, busy: boolean, held: boolean): boolean {
    if (!pointer) return false;
    if (pointer.hasGrip) return pointer.squeeze.down && !pointer.chorded;
    if ((pointer === this.brush && !held) || busy || this.bodyOf(pointer).on) return false;
    return pointer.tracked && pointer.click.down;
  }

  dispose(): void {
    for (const run of this.undo) run();
    for (const body of this.bodies) body.dispose();
  }
}

/**
 * Words for a session in which nothing points yet.  A session on a screen takes fingers, and inputs
 * of the eyes come with their first pinch.
 */
function firstWords(session: Session, hands: boolean): string {
  if (session.interactionMode === 'screen-space')
    return 'Touch the screen\nwhere you want to paint';
  const pinch = hands
    ? 'Look at a point and pinch,\nhold a hand in front of the headset'
    : 'Look at a point and pinch';
  return `${pinch},\nor press a system button of a controller`;
}

/** “right controller”; an input without a side has only the name of its kind. */
function nameOf({ side }: Pointer, kind: string): string {
  return side === 'none' ? kind : `${side} ${kind}`;
}
