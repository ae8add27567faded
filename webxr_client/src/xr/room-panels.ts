/** The panels in the room: where each hangs, which are there, and which fade. */
import { Vector3, type Group, type Matrix4, type Object3D } from 'three';
import { state } from '../state';
import { roomWay } from '../tools/ways';
import { watch } from '../watch';
import { faceEyes } from './facing';
import type { WorldControls } from './pages/view';
import { PalettePanel } from './palette-panel';
import { palmFacing } from './palm';
import { PaletteSpot, Placement, PLACEMENT, timelineBelow } from './placement';
import type { Panel } from './panel';
import { QuestionPanel } from './question-panel';
import type { Rig } from './rig';
import { xrSettings, type Side } from './settings';
import { SIZES } from './sizes';
import { TimelinePanel } from './timeline-panel';

/** Offset of the palette's middle from the hand that holds it: above, and towards the other one. */
const ABOVE = { up: 0.265, away: SIZES.palette.away } as const;
const HELD = {
  left: { ...ABOVE, right: 0.07 },
  right: { ...ABOVE, right: -0.07 },
  none: { ...ABOVE, right: 0 },
} as const;

/** An input that can hold the palette; `grip` in the headset's own space. */
export interface Holder {
  readonly side: Side | 'none';
  readonly tracked: boolean;
  /** It pinches, for whatever it may be. */
  readonly pinching: boolean;
  readonly grip: { readonly position: Vector3; readonly matrix: Matrix4 };
}

/** A pointer that has a panel by its bar, in the scene. */
export interface Carrier {
  readonly origin: Vector3;
  readonly direction: Vector3;
}

export class RoomPanels {
  readonly palette: PalettePanel;
  readonly timeline = new TimelinePanel({
    hide: () => this.showTimeline(false),
    togglePalette: () => (this.spot.putAway = !this.spot.putAway),
  });
  readonly question: QuestionPanel;
  readonly all: Panel[];
  /** Panels that also the hand that holds the palette can point at. */
  readonly far: Panel[];
  /** A panel that is none of the room's own. */
  added: Panel | null = null;
  private readonly placement: Placement;
  private readonly spot = new PaletteSpot();
  /** The palette hangs beside the timeline: it stays where it is. */
  private hangs = false;
  /** Metres below the eyes at which the timeline was laid, until carried elsewhere; 0: not yet. */
  private lies = 0;
  private carried = false;
  private readonly unwatch: () => void;

  constructor(
    private readonly rig: Rig,
    session: XRSession,
    private readonly world: Object3D,
    controls: WorldControls,
  ) {
    this.placement = new Placement(rig);
    const panels = {
      putAway: () => this.putPaletteAway(),
      toggleTimeline: () => this.toggleTimeline(),
    };
    this.palette = new PalettePanel({ ...controls, ...panels }, session);
    this.question = new QuestionPanel(() => this.ask());
    this.all = [this.palette, this.timeline, this.question];
    this.far = [this.timeline, this.question];
    const stops = [this.clearTheFloor(), watch([state.brush, xrSettings], () => this.giveWay())];
    this.unwatch = () => {
      for (const stop of stops) stop();
    };
  }

  addTo(rig: Group): void {
    for (const { mesh } of this.all) rig.add(mesh);
  }

  /** Take in another panel, which hangs above the palette's place. */
  add(panel: Panel): void {
    this.added = panel;
    this.all.push(panel);
    this.far.push(panel);
  }

  /** Lay the timeline before the person as they look now. */
  settle(): void {
    this.placement.face();
    this.carried = false;
    this.lies = timelineBelow(this.world.scale.x, roomWay());
    this.placement.layBefore(this.timeline.mesh, this.lies);
    if (this.added) this.placement.hangAbove(this.added.mesh, xrSettings.peek().hand === 'right');
  }

  /** Another tool may need the view that the timeline is in, unless a person put it there. */
  private giveWay(): void {
    const low = timelineBelow(this.world.scale.x, roomWay()) !== this.lies;
    if (this.lies > 0 && low && !this.carried) this.settle();
  }

  toggleTimeline(): void {
    this.showTimeline(!this.timeline.mesh.visible);
  }

  private showTimeline(on: boolean): void {
    this.timeline.mesh.visible = on;
    if (on) this.settle();
    // Something must be left to press.
    else if (this.spot.handless) this.spot.putAway = false;
  }

  private putPaletteAway(): void {
    this.spot.putAway = true;
    if (this.spot.handless && !this.timeline.mesh.visible) this.showTimeline(true);
  }

  private ask(): void {
    this.placement.face();
    this.placement.layBefore(this.question.mesh, PLACEMENT.question);
  }

  /** Hang the palette, and fade what lies before the points while one paints. */
  update(holder: Holder | null, painting: boolean, seconds: Float64Array): void {
    const { mesh } = this.palette;
    const { headInRig } = this.rig;
    const there = holder?.tracked === true;
    const free = there && !holder.pinching;
    const palm = free ? palmFacing(holder.grip.matrix, holder.side, headInRig) : 0;
    const spot = this.spot.update(there, painting, palm, seconds);
    const was = mesh.visible;
    mesh.visible = spot !== 'away';
    if (spot === 'hand') {
      faceEyes(mesh, holder!.grip.position, headInRig, HELD[holder!.side]);
    } else if (spot === 'beside' && !(was && this.hangs)) {
      this.placement.hangBeside(mesh, xrSettings.peek().hand === 'right');
    }
    this.hangs = spot === 'beside';
    if (mesh.visible) mesh.updateMatrixWorld();
    this.timeline.fade(painting);
    this.question.fade(painting);
  }

  /** Let a panel follow what has its bar. */
  carry(panel: Panel, by: Carrier): void {
    this.placement.carry(panel, by);
    this.carried ||= panel === this.timeline;
  }

  /** The timeline lies where one points at the floor: it makes way for that. */
  private clearTheFloor(): () => void {
    const { mesh } = this.timeline;
    let away = false;
    return watch([state.tool], () => {
      const pointing = state.tool.peek() === 'floor';
      if (pointing) away = mesh.visible;
      if (pointing || away) mesh.visible = !pointing;
      if (!pointing) away = false;
    });
  }

  dispose(): void {
    this.unwatch();
    for (const panel of this.all) panel.dispose();
  }
}
