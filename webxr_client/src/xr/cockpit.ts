/**
 * Everything that is there while one is inside: hands, brush, panels, moving about.  `update` runs
 * before each picture and allocates nothing unless something happens.
 */
import { effect } from '@preact/signals';
import { Quaternion, Vector3 } from 'three';
import { actions } from '../actions';
import type { Engine } from '../engine/engine';
import { isActive, notify, state } from '../state';
import { Body } from './body';
import { Buttons } from './buttons';
import { Hand } from './hand';
import { BUMP, FRAME_TICK, type Pulse } from './haptics';
import { Hud } from './hud';
import { Locomotion } from './locomotion';
import { Painter } from './painter';
import { PalettePanel } from './palette-panel';
import type { Panel } from './panel';
import { Place } from './place';
import { Presence } from './presence';
import { Rig } from './rig';
import { xrSettings, type Side } from './settings';
import { TimelinePanel } from './timeline-panel';
import { layLow, standBefore } from './standing';
import { Lessons } from './tips';
import { Trail } from './trail';
import { resetWorld, scaleAbout, WorldGrab } from './world';

export class Cockpit {
  readonly rig = new Rig();
  readonly hands: Record<Side, Hand> = { left: new Hand('left'), right: new Hand('right') };
  readonly painter: Painter;
  readonly palette: PalettePanel;
  readonly timeline = new TimelinePanel();
  /** Pictures since the session began, for tests. */
  frames = 0;
  private readonly lessons = new Lessons();
  private readonly bodies: readonly Body[];
  private readonly place: Place;
  private readonly locomotion = new Locomotion(this.rig);
  private readonly grab = new WorldGrab();
  private readonly buttons: Buttons;
  private readonly hud: Hud;
  private readonly presence: Presence;
  private readonly trail: Trail;
  private readonly undo: (() => void)[] = [];
  private readonly headTurn = new Quaternion();
  private readonly panels: readonly Panel[];
  private readonly farPanels: readonly Panel[];
  private standing = false;
  private last = -1;
  private frame = -1;

  constructor(
    private readonly engine: Engine,
    private readonly session: XRSession,
    /** Added where the headset does not know the floor. */
    private readonly height: number,
    readonly mode: XRSessionMode,
  ) {
    const { viewer } = engine;
    this.place = new Place(viewer);
    this.painter = new Painter(engine, this.place, (strength, ms) =>
      this.brushHand.pulse(strength, ms),
    );
    this.palette = new PalettePanel({
      scaleTo: (scale) => this.scaleTo(scale),
      reset: () => this.reset(),
    });
    this.panels = [this.palette, this.timeline];
    this.farPanels = [this.timeline];
    this.buttons = new Buttons(this.lessons, () => this.toggleTimeline());
    this.hud = new Hud();
    this.presence = new Presence(engine.link);
    this.trail = new Trail(engine, viewer.room);
    this.bodies = [this.hands.left, this.hands.right].map((hand) => new Body(hand, this.lessons));
    this.assemble();
    this.listen();
  }

  /** The hand that paints, and the one that holds the palette. */
  get brushHand(): Hand {
    return this.hands[xrSettings.peek().hand];
  }

  get otherHand(): Hand {
    return this.hands[xrSettings.peek().hand === 'right' ? 'left' : 'right'];
  }

  private assemble(): void {
    const { viewer } = this.engine;
    const { group } = this.rig;
    group.position.y = this.height;
    viewer.scene.add(group);
    group.add(viewer.camera, this.timeline.mesh, this.hud.group);
    for (const body of this.bodies) body.addTo(viewer.scene, group);
    this.painter.addTo(viewer.scene);
    this.locomotion.addTo(viewer.scene);
    this.holdPalette();
  }

  /** The palette lies over the other hand, turned to the face. */
  private holdPalette(): void {
    const hand = this.otherHand;
    const side = hand.side === 'left' ? 1 : -1;
    this.palette.mesh.position.set(side * 0.09, 0.19, -0.13);
    this.palette.mesh.rotation.set(-0.75, 0, 0);
    hand.grip.add(this.palette.mesh);
    for (const body of this.bodies) body.explain(body.hand === this.brushHand);
  }

  private listen(): void {
    const { session, undo } = this;
    const on = <K extends keyof XRSessionEventMap>(
      type: K,
      run: (event: XRSessionEventMap[K]) => void,
    ): void => {
      session.addEventListener(type, run as EventListener);
      undo.push(() => session.removeEventListener(type, run as EventListener));
    };
    on('inputsourceschange', (event) => this.sources(event.added, event.removed));
    on('selectstart', (event) => this.bodyOf(event.inputSource)?.hand.select(true));
    on('selectend', (event) => this.bodyOf(event.inputSource)?.hand.select(false));
    on('visibilitychange', () => {
      if (session.visibilityState !== 'visible') this.painter.finish();
    });
    this.sources([...session.inputSources], []);
    const tick = (now: number, frame: XRFrame | undefined): void => this.update(now, frame);
    this.engine.viewer.ticks.add(tick);
    undo.push(() => this.engine.viewer.ticks.delete(tick));
    let side = xrSettings.peek().hand;
    undo.push(
      effect(() => {
        if (xrSettings.value.hand === side) return;
        side = xrSettings.value.hand;
        this.painter.finish();
        this.holdPalette();
      }),
      this.followJobs(),
    );
  }

  /** A bump when a tracking run ends. */
  private followJobs(): () => void {
    let running = new Set<string>();
    return effect(() => {
      const tracking = state.jobs.value.filter((job) => job.kind === 'tracking');
      const active = new Set(tracking.filter(isActive).map((job) => job.id));
      const ended = [...running].some((id) => !active.has(id));
      running = active;
      if (ended) this.feel(this.brushHand, BUMP);
    });
  }

  private bodyOf(source: XRInputSource): Body | undefined {
    return this.bodies.find(({ hand }) => hand.source === source);
  }

  private sources(added: readonly XRInputSource[], removed: readonly XRInputSource[]): void {
    for (const source of removed) {
      const body = this.bodyOf(source);
      if (!body) continue;
      if (body.hand === this.brushHand) this.painter.finish();
      body.strip();
      this.hud.say(`The ${body.hand.side} controller is away`);
    }
    for (const source of added) {
      if (source.targetRayMode !== 'tracked-pointer') continue;
      const side: Side = source.handedness === 'left' ? 'left' : 'right';
      const body = this.bodies.find(({ hand }) => hand.side === side)!;
      body.dress(source, body.hand === this.brushHand, this.rig.group);
    }
  }

  // ── each frame ─────────────────────────────────────────────────────────────────────────────

  private update(now: number, frame: XRFrame | undefined): void {
    const space = this.engine.viewer.renderer.xr.getReferenceSpace();
    if (!frame || !space) return;
    const seconds = this.last < 0 ? 0 : Math.min(0.1, (now - this.last) / 1000);
    this.last = now;
    this.frames += 1;
    if (!this.rig.update(frame, space)) return;
    if (!this.standing) this.stand();
    const { left, right } = this.hands;
    const { matrixWorld } = this.rig.group;
    left.update(frame, space, matrixWorld);
    right.update(frame, space, matrixWorld);
    for (const body of this.bodies) body.follow(frame, space, matrixWorld);
    this.rig.group.updateMatrixWorld(true);
    this.moveWorld();
    this.place.update();
    for (const body of this.bodies) {
      const brush = body.hand === this.brushHand;
      // The hand that holds the palette cannot point at it.
      body.point(brush ? this.panels : this.farPanels, brush ? this.painter : null);
    }
    this.buttons.update(this.brushHand, this.otherHand, seconds, now);
    this.locomotion.update(this.otherHand, seconds);
    this.paint(now);
    this.followFrame();
    this.trail.update();
    this.tellOthers(now);
    this.engine.viewer.backdrop.follow(this.rig.head);
    for (const panel of this.panels) panel.update(now);
    for (const { tips } of this.bodies) tips.update(seconds, xrSettings.peek().tips);
    this.hud.update(this.rig, seconds, now);
  }

  private stand(): void {
    const frame = this.engine.playback.frame;
    if (!frame || !standBefore(frame, this.engine.viewer.room.matrix, this.rig)) return;
    this.standing = true;
    layLow(this.timeline.mesh, this.rig);
  }

  private toggleTimeline(): void {
    const { mesh } = this.timeline;
    mesh.visible = !mesh.visible;
    if (mesh.visible) layLow(mesh, this.rig);
  }

  private moveWorld(): void {
    const { left, right } = this.hands;
    const { world } = this.engine.viewer;
    const was = this.grab.active;
    const grown = this.grab.update(
      world,
      left.squeeze.down ? left.place : null,
      right.squeeze.down ? right.place : null,
    );
    if (this.grab.active && !was) this.lessons.done('grab');
    // The ball keeps its size in the hand.
    if (grown !== 1) actions.setRadius(state.brush.peek().radius / grown);
  }

  private paint(now: number): void {
    const hand = this.brushHand;
    const body = this.bodies.find((other) => other.hand === hand)!;
    const before = this.painter.painting;
    this.painter.update(
      hand,
      this.otherHand,
      this.rig.head,
      body.on !== null || this.grab.active,
      now,
    );
    if (this.painter.painting && !before) this.lessons.done('paint');
  }

  private followFrame(): void {
    const frame = state.frame.peek();
    if (frame === this.frame) return;
    // While it plays the hand would only buzz.
    if (this.frame >= 0 && !state.playing.peek()) this.feel(this.brushHand, FRAME_TICK);
    this.frame = frame;
  }

  private tellOthers(now: number): void {
    const { camera, world } = this.engine.viewer;
    camera.getWorldQuaternion(this.headTurn);
    this.presence.update(
      now,
      this.rig,
      this.order,
      this.painter.tip,
      this.headTurn,
      world.matrixWorld,
    );
  }

  private readonly order = [this.hands.left, this.hands.right];

  private feel(hand: Hand, { strength, milliseconds }: Pulse): void {
    hand.pulse(strength, milliseconds);
  }

  // ── the world ──────────────────────────────────────────────────────────────────────────────

  private scaleTo(scale: number): void {
    const { world } = this.engine.viewer;
    const about = new Vector3().copy(this.rig.head).addScaledVector(this.rig.ahead, 0.6);
    about.y = scale < 1 ? 0.8 : 0;
    const grown = scale / world.scale.x;
    scaleAbout(world, scale, about);
    actions.setRadius(state.brush.peek().radius / grown);
  }

  /** 1:1 on the floor, before the middle, facing it. */
  reset(): void {
    const { world } = this.engine.viewer;
    actions.setRadius(state.brush.peek().radius * world.scale.x);
    resetWorld(world);
    this.stand();
    notify('info', 'Back at true scale', 'The recording stands on the floor, and you before it.');
  }

  dispose(): void {
    const { viewer } = this.engine;
    for (const run of this.undo) run();
    this.presence.gone();
    this.painter.dispose();
    this.trail.dispose();
    this.locomotion.dispose();
    for (const body of this.bodies) body.dispose();
    for (const panel of this.panels) panel.dispose();
    this.hud.dispose();
    viewer.camera.removeFromParent();
    this.rig.group.removeFromParent();
    resetWorld(viewer.world);
  }
}
