/** The two hands: who comes and goes, what they hold, what their rays are on. */
import { Body } from './body';
import { Hand } from './hand';
import type { Painter } from './painter';
import type { Panel } from './panel';
import { Poses } from './poses';
import type { Rig } from './rig';
import { xrSettings, type Side } from './settings';
import type { Lessons } from './lessons';

/** Seconds after which a controller out of the headset's sight is missed. */
const MISSED = 1;

export interface Changes {
  /** The hand that paints is not there any more. */
  brushGone(): void;
  /** Something to be told. */
  say(text: string): void;
}

export class Controllers {
  readonly hands: Record<Side, Hand> = { left: new Hand('left'), right: new Hand('right') };
  readonly both: readonly Hand[] = [this.hands.left, this.hands.right];
  readonly bodies: readonly Body[];
  /** Seconds for which each has been out of sight. */
  private readonly unseen = new Float64Array(2);
  private readonly undo: (() => void)[] = [];

  constructor(
    private readonly session: XRSession,
    private readonly poses: Poses,
    private readonly rig: Rig,
    lessons: Lessons,
    private readonly changes: Changes,
  ) {
    this.bodies = this.both.map((hand) => new Body(hand, lessons));
  }

  /** The hand that paints, and the one that holds the palette. */
  get brush(): Hand {
    return this.hands[xrSettings.peek().hand];
  }

  get other(): Hand {
    return this.hands[xrSettings.peek().hand === 'right' ? 'left' : 'right'];
  }

  bodyOf(hand: Hand): Body {
    return this.bodies[hand === this.hands.left ? 0 : 1]!;
  }

  listen(): void {
    const { session } = this;
    const on = <K extends keyof XRSessionEventMap>(
      type: K,
      run: (event: XRSessionEventMap[K]) => void,
    ): void => {
      session.addEventListener(type, run as EventListener);
      this.undo.push(() => session.removeEventListener(type, run as EventListener));
    };
    on('inputsourceschange', (event) => this.sources(event.added, event.removed));
    on('selectstart', (event) => this.holder(event.inputSource)?.hand.select(true));
    on('selectend', (event) => this.holder(event.inputSource)?.hand.select(false));
    on('visibilitychange', () => {
      if (session.visibilityState !== 'visible') this.changes.brushGone();
    });
    this.sources([...session.inputSources], []);
  }

  private holder(source: XRInputSource): Body | undefined {
    return this.bodies.find(({ hand }) => hand.source === source);
  }

  private sources(added: readonly XRInputSource[], removed: readonly XRInputSource[]): void {
    for (const source of removed) {
      const body = this.holder(source);
      if (!body) continue;
      if (body.hand === this.brush) this.changes.brushGone();
      body.strip();
      this.poses.setHand(body.hand.side === 'left' ? 0 : 1, null);
      this.changes.say(`The ${body.hand.side} controller is away`);
    }
    for (const source of added) {
      if (source.targetRayMode !== 'tracked-pointer') continue;
      const side: Side = source.handedness === 'left' ? 'left' : 'right';
      const body = this.bodyOf(this.hands[side]);
      this.poses.setHand(side === 'left' ? 0 : 1, source);
      body.dress(source, body.hand === this.brush, this.rig.group);
    }
  }

  /** The tips of both, after a change of sides. */
  explain(): void {
    for (const body of this.bodies) body.explain(body.hand === this.brush);
  }

  update(frame: XRFrame, space: XRReferenceSpace, seconds: Float64Array): void {
    const { matrixWorld } = this.rig.group;
    for (let i = 0; i < this.both.length; i++) {
      this.both[i]!.update(this.poses, matrixWorld);
      this.miss(i, seconds);
    }
    for (let i = 0; i < this.bodies.length; i++) this.bodies[i]!.follow(frame, space, matrixWorld);
  }

  /** Say once that a controller is out of sight; bare hands come and go. */
  private miss(i: number, seconds: Float64Array): void {
    const { unseen } = this;
    const hand = this.both[i]!;
    if (!hand.source || hand.tracked || hand.isHand) {
      unseen[i] = 0;
      return;
    }
    const missed = unseen[i]! >= MISSED;
    unseen[i]! += seconds[0]!;
    if (!missed && unseen[i]! >= MISSED) {
      this.changes.say(`The headset does not see the ${hand.side} controller`);
    }
  }

  /** Show what the buttons do, as far as it is not learnt; a hand that points at a panel needs none. */
  teach(seconds: Float64Array): void {
    const { tips } = xrSettings.peek();
    for (let i = 0; i < this.bodies.length; i++) {
      const body = this.bodies[i]!;
      body.tips.update(seconds, tips && body.on === null, this.rig.headInRig);
    }
  }

  /** `far`: what also the hand that holds the palette can point at. */
  point(panels: readonly Panel[], far: readonly Panel[], painter: Painter): void {
    for (let i = 0; i < this.bodies.length; i++) {
      const body = this.bodies[i]!;
      const paints = body.hand === this.brush;
      body.point(paints ? panels : far, paints ? painter : null);
    }
  }

  /**
   * Whether a hand holds the room.  Without a grip the trigger of the hand that does not paint
   * takes hold, unless it is needed for something else.
   */
  holds(hand: Hand, busy: boolean): boolean {
    if (hand.hasGrip) return hand.squeeze.down && !hand.chorded;
    if (hand === this.brush || busy || this.bodyOf(hand).on) return false;
    return hand.tracked && hand.click.down;
  }

  dispose(): void {
    for (const run of this.undo) run();
    for (const body of this.bodies) body.dispose();
  }
}
