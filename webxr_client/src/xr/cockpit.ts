/**
 * Everything that is there while one is inside: hands, brush, panels, moving about.  `update` runs
 * before each picture and allocates nothing unless something happens.
 */
import { Vector3 } from 'three';
import { actions } from '../store/actions';
import type { Engine } from '../engine/engine';
import { Listeners } from '../store/listeners';
import { follow, peek, watch } from '../store/watch';
import { notify, state } from '../store/state';
import { roomWay } from '../tools/ways';
import { marked, markedFrom, RISE } from '../work/places';
import { Buttons } from './input/buttons';
import { answersAt } from './painting/answers';
import { Cues } from './painting/cues';
import { EventHaptics, LEVEL_TICK, type Pulse as Haptic } from './input/haptics';
import { Hud } from './panels/hud';
import { followInterruptions } from './interruptions';
import { Locomotion } from './moving/locomotion';
import { Painter } from './painting/painter';
import type { Panel } from './panels/panel';
import { Place } from './painting/place';
import type { Pointer } from './input/pointer';
import { Pointers } from './bodies/pointers';
import type { Poses } from './input/poses';
import { Presence } from './bodies/presence';
import { Pulse } from './panels/pulse';
import { Rig } from './moving/rig';
import { RoomPanels } from './panels/room-panels';
import { xrSettings } from '../store/xr-settings';
import { standBefore, standRound } from './moving/standing';
import { RoomScale } from './moving/room-scale';
import { TipSign } from './painting/tip-sign';
import { Lessons } from './input/lessons';
import { UpDown } from './input/up-down';
import { LabelRing } from './bodies/label-ring';
import { resetWorld, WorldGrab } from './moving/world';

/** Metres from the floor to the eyes of a standing person. */
const EYES = 1.6;
/** Two pinches that begin within this, milliseconds, are one gesture. */
const TOGETHER_MS = 250;
/** A press was the system's gesture when the system answers it within this, milliseconds. */
const SYSTEM_MS = 600;
const COVERED = 'Not painted: the system took this press';

export class Cockpit {
  readonly rig = new Rig();
  readonly pointers: Pointers;
  readonly painter: Painter;
  readonly panels: RoomPanels;
  /** Pictures since the session began, for tests. */
  frames = 0;
  readonly lessons = new Lessons();
  readonly locomotion = new Locomotion(this.rig);
  private readonly place: Place;
  private readonly grab = new WorldGrab();
  private readonly buttons: Buttons;
  private readonly upDown: UpDown;
  private readonly ring: LabelRing;
  private readonly hud = new Hud();
  private readonly cues = new Cues(this.rig);
  private readonly tipSign: TipSign;
  private readonly scale: RoomScale;
  private readonly presence: Presence;
  private readonly feelings: EventHaptics;
  private readonly pulse: Pulse;
  private readonly undo: (() => void)[] = [];
  private readonly parts = new Listeners<number>();
  private standing = false;
  /** Of the rig, when the hand was last looked at. */
  private jumps = 0;
  /** Times of the last picture, and since it: numbers on their own would be boxed. */
  private readonly last = Float64Array.of(-1);
  private readonly seconds = new Float64Array(1);

  constructor(
    private readonly engine: Engine,
    private readonly session: XRSession,
    private readonly poses: Poses,
    /** Whether the headset knows where the floor is. */
    readonly floor: boolean,
    readonly mode: XRSessionMode,
  ) {
    const { viewer } = engine;
    this.place = new Place(viewer);
    const pulseBrush = (strength: number, ms: number): void =>
      this.cues.give(this.brush, this.painter, strength, ms);
    this.painter = new Painter(engine, this.place, pulseBrush);
    this.pointers = new Pointers(session, poses, this.rig, viewer.scene, this.lessons, {
      brushGone: () => this.painter.finish(),
      showMessage: (text) => this.hud.showMessage(text),
    });
    this.scale = new RoomScale(viewer, this.rig, (settles) => {
      this.interrupt();
      if (settles) this.settle(peek(xrSettings).seated);
      else this.panels.settle();
    });
    this.panels = new RoomPanels(engine, this.rig, session, {
      scaleTo: (scale) => this.scale.to(scale),
      reset: () => this.scale.reset(),
      recentre: () => this.stand(),
      armTeleport: () => this.locomotion.armTeleport(),
    });
    const sendPulse = ({ strength, milliseconds }: Haptic): void =>
      pulseBrush(strength, milliseconds);
    this.tipSign = new TipSign(() => sendPulse(LEVEL_TICK));
    this.buttons = new Buttons(this.lessons, () => this.panels.toggleTimeline());
    this.upDown = new UpDown({
      answers: (hand) => answersAt(this.place, hand),
      marked: () => sendPulse(LEVEL_TICK),
      taken: ({ device }) => this.lessons.markDone('label', device),
      level: (step) => this.painter.stepLevel(step),
    });
    this.ring = new LabelRing(this.upDown);
    this.presence = new Presence(engine.link, viewer.afterwards);
    this.feelings = new EventHaptics(sendPulse);
    this.pulse = new Pulse(viewer.uniforms, this.panels.palette);
    this.assemble();
    this.listen();
  }

  /** The pointer that paints. */
  get brush(): Pointer | null {
    return this.pointers.brush;
  }

  /** Add a panel to the room; the result removes it. */
  hang(panel: Panel): () => void {
    this.rig.group.add(panel.mesh);
    const stops = [this.parts.add((now) => panel.update(now)), this.panels.add(panel)];
    return () => stops.forEach((stop) => stop());
  }

  private assemble(): void {
    const { viewer } = this.engine;
    const { group } = this.rig;
    viewer.scene.add(group);
    group.add(viewer.camera, this.hud.group, this.tipSign.group, this.ring.group);
    this.panels.addTo(group);
    this.painter.addTo(viewer.scene);
    this.locomotion.addTo(viewer.scene);
  }

  private listen(): void {
    const { undo } = this;
    this.pointers.listen();
    this.divide();
    undo.push(this.engine.viewer.ticks.add((now, frame) => this.update(now, frame)));
    const space = this.engine.viewer.renderer.xr.getReferenceSpace();
    undo.push(
      followInterruptions(this.session, space, {
        moved: () => {
          this.standing = false;
          this.interrupt();
        },
        covered: () => this.cover(),
      }),
    );
    this.session.addEventListener('select', this.cues.wake);
    undo.push(() => this.session.removeEventListener('select', this.cues.wake));
    undo.push(watch([marked], () => this.visit()));
    let { hand: side, seated } = peek(xrSettings);
    undo.push(
      follow(() => {
        const { value } = xrSettings;
        if (value.seated !== seated) this.settle(value.seated);
        seated = value.seated;
        if (value.hand === side) return;
        side = value.hand;
        this.pointers.assign();
      }),
    );
  }

  /** Undo a bare press that was the system's gesture; strokes of a trigger stay. */
  private cover(): void {
    const { brush, painter } = this;
    if (brush?.kind.fleeting !== true) painter.interrupt(brush);
    else if (painter.withdraw(performance.now(), SYSTEM_MS)) notify('info', COVERED);
  }

  // ── each frame ─────────────────────────────────────────────────────────────────────────────

  private update(now: number, frame: XRFrame | undefined): void {
    const space = this.engine.viewer.renderer.xr.getReferenceSpace();
    if (!frame || !space) return;
    const { seconds, last } = this;
    seconds[0] = last[0]! < 0 ? 0 : Math.min(0.1, (now - last[0]!) / 1000);
    last[0] = now;
    this.frames += 1;
    this.poses.read(frame, space);
    if (!this.rig.update(this.poses)) return;
    this.rig.sight.take(this.engine.viewer.renderer.xr.getCamera().cameras);
    if (!this.standing) this.stand();
    this.pointers.update(frame, space, seconds);
    this.rig.group.updateMatrixWorld(true);
    this.parts.run(now);
  }

  /** Draw the parts of a picture, each guarded: haptics that fail must not still the panels. */
  private divide(): void {
    const { parts, pointers, seconds } = this;
    parts.add(() => this.panels.update(pointers.palette, this.painter.painting, seconds));
    parts.add((now) => this.moveWorld(now));
    parts.add(() => this.place.update());
    parts.add(() => pointers.point(this.panels.all, this.panels.far, this.painter));
    parts.add(() => this.carryPanels());
    parts.add(() => this.panels.fold(pointers.at, seconds));
    parts.add((now) => this.upDown.update(pointers.brush, now));
    parts.add((now) => this.buttons.update(pointers.brush, pointers.other, seconds, now));
    parts.add(() => this.go());
    parts.add((now) => this.paint(now));
    parts.add(() => this.feelings.update());
    parts.add((now) => this.sendPresence(now));
    parts.add(() => this.engine.viewer.backdrop.follow(this.rig.head));
    for (const panel of this.panels.all) parts.add((now) => panel.update(now));
    parts.add((now) => this.pulse.update(now));
    parts.add(() => this.teach());
    parts.add((now) => this.tipSign.update(this.rig, this.brush, this.painter, now));
    parts.add(() => this.ring.update(pointers.brushBody, this.rig));
    parts.add((now) => this.hud.update(this.rig, seconds, now));
  }

  /** Lift seated people, and people without a floor, to the eye height of standing people. */
  private settle(seated: boolean): void {
    const lifted = seated || !this.floor;
    this.rig.liftTo(lifted ? EYES - this.rig.headInRig.y : 0);
    this.panels.settle();
  }

  private teach(): void {
    const busy = this.painter.painting || this.upDown.shown;
    this.pointers.teach(this.seconds, busy, this.panels.all);
  }

  /** Before the recording, as large as it is now and wherever it was moved, the timeline at hand. */
  private stand(): void {
    const { room } = this.engine.viewer;
    const frame = this.engine.playback.frame;
    room.updateWorldMatrix(true, false);
    const info = peek(state.sequence);
    if (!frame || !info) return;
    if (!standBefore(frame, room.matrixWorld, this.rig, info.shift)) return;
    this.standing = true;
    this.settle(peek(xrSettings).seated);
  }

  /** Before the piece that is asked about. */
  private visit(): void {
    const place = marked.peek();
    const info = state.sequence.peek();
    if (!place || !info || !this.standing || markedFrom.peek() === 0) return;
    const { room, world } = this.engine.viewer;
    const at = new Vector3(...place).sub(new Vector3(...info.shift)).applyMatrix4(room.matrixWorld);
    standRound(at, markedFrom.peek() * world.scale.x, RISE, this.rig);
    this.panels.settle();
  }

  private carryPanels(): void {
    const { bodies } = this.pointers;
    for (let i = 0; i < bodies.length; i++) {
      const { carries, pointer } = bodies[i]!;
      if (carries) this.panels.carry(carries, pointer);
    }
  }

  private moveWorld(now: number): void {
    const { brush, other } = this.pointers;
    const { world } = this.engine.viewer;
    const was = this.grab.active;
    if (other?.hasGrip === false && other.edge.click === 1) this.painter.withdraw(now, TOGETHER_MS);
    // Both triggers make a box between the hands.
    const busy = this.painter.painting || roomWay().name === 'box';
    const grown = this.grab.update(
      world,
      this.pointers.holds(other, busy, was) ? other!.place : null,
      this.pointers.holds(brush, busy, was) ? brush!.place : null,
    );
    if (this.grab.active && !was) this.lessons.markDone('grab', (other ?? brush)!.device);
    // The sphere keeps its size in the hand.
    if (grown !== 1) actions.tools.setRadius(peek(state.brush).radius / grown);
  }

  private go(): void {
    const { brush, other } = this.pointers;
    const { locomotion, grab, seconds } = this;
    locomotion.update(other, brush, this.pointing(brush), grab.active, seconds);
  }

  /** Whether a pointer is on a panel. */
  private pointing(pointer: Pointer | null): boolean {
    return pointer !== null && this.pointers.bodyOf(pointer).on !== null;
  }

  private paint(now: number): void {
    const { brush, other } = this.pointers;
    const before = this.painter.painting;
    const blocked = this.pointing(brush) || this.grab.active || this.locomotion.waits;
    if (this.rig.jumps !== this.jumps) this.interrupt();
    this.jumps = this.rig.jumps;
    this.painter.update(brush, other, this.rig.head, blocked, now);
    this.painter.completion.update(this.pointing(brush) || !this.panels.palette.folded, now);
    if (brush && this.painter.painting && !before) this.lessons.markDone('paint', brush.device);
  }

  /** End the stroke and ignore presses until their release, as the targets have moved. */
  private interrupt(): void {
    this.painter.interrupt(this.brush);
    this.pointers.disarm();
  }

  private sendPresence(now: number): void {
    const { rig, painter, pointers } = this;
    this.presence.update(now, rig, pointers, painter.tip, this.engine.viewer.world);
  }

  dispose(): void {
    const { viewer } = this.engine;
    for (const run of this.undo) run();
    this.presence.leave();
    this.painter.dispose();
    this.feelings.dispose();
    this.cues.dispose();
    this.pulse.dispose();
    this.locomotion.dispose();
    this.ring.dispose();
    this.pointers.dispose();
    this.panels.dispose();
    this.hud.dispose();
    this.tipSign.dispose();
    viewer.camera.removeFromParent();
    this.rig.group.removeFromParent();
    resetWorld(viewer.world);
  }
}
