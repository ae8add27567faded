/** The panels in the room: where each hangs, which is folded to its handle, and which fade. */
import { Vector3, type Group, type Matrix4 } from 'three';
import type { Engine } from '../../engine/engine';
import { faceEyes } from '../drawing/facing';
import type { WorldControls } from './pages/view';
import { PalettePanel } from './palette-panel';
import { palmFacing } from '../input/palm';
import { type PanelLevel, PaletteSpot, Placement, PLACEMENT } from './placement';
import type { Panel } from './panel';
import type { Pointer } from '../input/pointer';
import { QuestionPanel } from './question-panel';
import { QuestionPlace } from './question-place';
import type { Rig } from '../moving/rig';
import type { Side } from '../../store/xr-settings';
import { SIZES } from '../drawing/sizes';
import { TimelinePanel } from './timeline-panel';

/** Offset of the palette's middle from the hand that holds it: above, and towards the other one. */
const ABOVE = { up: 0.257, distance: SIZES.palette.distance } as const;
const HELD = {
  left: { ...ABOVE, right: 0.015 },
  right: { ...ABOVE, right: -0.11 },
  none: { ...ABOVE, right: 0 },
} as const;

/** An input that can hold the palette; `grip` in the headset's own space. */
export interface Holder {
  readonly side: Side | 'none';
  readonly tracked: boolean;
  /** It pinches, for any purpose. */
  readonly pinching: boolean;
  readonly grip: { readonly position: Vector3; readonly matrix: Matrix4 };
}

/** A pointer that has a panel by its bar, in the scene. */
export interface Carrier {
  readonly origin: Vector3;
  readonly direction: Vector3;
}

/** Cosines of the angle to the eyes' direction from which they call a handle that is held, and keep its panel. */
const [CALLS, KEEPS] = [0.97, 0.96];

export class RoomPanels {
  readonly palette: PalettePanel;
  readonly timeline = new TimelinePanel({
    // A palette without a hand hangs before it.
    opens: () => this.spot.handless && this.palette.setFolded(true),
    hide: () => this.timeline.setFolded(true),
    callPalette: () => this.palette.setFolded(false),
  });
  readonly question: QuestionPanel;
  readonly all: Panel[];
  /** Panels that also the hand that holds the palette can point at. */
  readonly far: Panel[];
  /** A panel that is none of the room's own. */
  added: Panel | null = null;
  private readonly placement: Placement;
  private readonly questionPlace: QuestionPlace;
  private readonly spot = new PaletteSpot();
  /** The palette hangs beside the timeline's handle: no hand holds it. */
  private hangs = false;
  /** Heights of hanging panels; empty until they are placed again. */
  private readonly panelLevels = new Map<Panel, PanelLevel>();
  private readonly middle = new Vector3();

  constructor(
    private readonly engine: Engine,
    private readonly rig: Rig,
    session: XRSession,
    controls: WorldControls,
  ) {
    this.placement = new Placement(rig);
    this.questionPlace = new QuestionPlace(engine, rig, this.placement);
    const panels = {
      foldPalette: () => this.palette.setFolded(true),
      toggleTimeline: () => this.toggleTimeline(),
    };
    this.palette = new PalettePanel({ ...controls, ...panels }, session);
    this.question = new QuestionPanel(() => this.ask());
    this.all = [this.palette, this.timeline, this.question];
    this.far = [this.timeline, this.question];
  }

  addTo(rig: Group): void {
    for (const { mesh } of this.all) rig.add(mesh);
  }

  /** Take in another panel, which hangs before the person, above the points; the result removes it. */
  add(panel: Panel): () => void {
    this.added = panel;
    this.all.push(panel);
    this.far.push(panel);
    this.placement.layBefore(panel.mesh, PLACEMENT.added);
    return () => {
      for (const list of [this.all, this.far]) list.splice(list.indexOf(panel), 1);
      this.added = null;
      panel.dispose();
    };
  }

  /** Place the hanging panels in front of the person's current gaze. */
  settle(): void {
    this.placement.face();
    this.panelLevels.clear();
    this.arrange();
    if (this.added) this.placement.layBefore(this.added.mesh, PLACEMENT.added);
  }

  /** Hang timeline and palette where they hide neither a handle nor a model, if that is elsewhere now. */
  private arrange(): void {
    const { panelLevels, palette, timeline, placement } = this;
    const { handless } = this.spot;
    const model = this.engine.viewer.world.scale.x < 1;
    const forTimeline = timeline.folded ? 'low' : model ? 'under' : handless ? 'raised' : 'low';
    if (panelLevels.get(timeline) !== forTimeline) placement.hangTimeline(timeline, forTimeline);
    panelLevels.set(timeline, forTimeline);
    if (!handless) return;
    const forPalette = forTimeline === 'under' && palette.folded ? 'between' : 'low';
    if (panelLevels.get(palette) !== forPalette) placement.hangPalette(palette, forPalette);
    panelLevels.set(palette, forPalette);
  }

  /** Unfold the timeline where one looks, or fold it. */
  toggleTimeline(): void {
    const { timeline } = this;
    if (timeline.folded) this.settle();
    timeline.setFolded(!timeline.folded);
  }

  /** Lay the question before the eyes, and fold the timeline, which would hide the object. */
  private ask(): void {
    this.timeline.setFolded(true);
    this.placement.face();
    this.placement.layBefore(this.question.mesh, PLACEMENT.question);
    this.questionPlace.begin();
  }

  /** Place the palette, and fade panels in front of the points during a stroke. */
  update(holder: Holder | null, painting: boolean, seconds: Float64Array): void {
    const { palette, timeline, rig } = this;
    const isTracked = holder?.tracked === true;
    const free = isTracked && !holder.pinching;
    const palm = free ? palmFacing(holder.grip.matrix, holder.side, rig.headInRig) : 0;
    const spot = this.spot.update(isTracked, painting, palm, seconds);
    if (this.spot.isRequested) palette.setFolded(false);
    if (spot === 'hand') {
      faceEyes(palette.mesh, holder!.grip.position, rig.headInRig, HELD[holder!.side]);
      this.panelLevels.delete(palette);
    }
    this.hangs = spot === 'beside';
    this.arrange();
    palette.mesh.visible = spot !== 'away';
    if (palette.mesh.visible) palette.mesh.updateMatrixWorld();
    timeline.fade(painting);
    this.question.fade(painting);
    this.questionPlace.update(this.question, performance.now());
  }

  /** Fold and unfold; `by`: the pointer on a panel. */
  fold(by: (panel: Panel) => Pointer | null, seconds: Float64Array): void {
    const { palette, timeline } = this;
    // Eyes on a hanging panel may look at the points behind it.
    const looked = !this.hangs && this.looked(palette, palette.folded ? CALLS : KEEPS);
    palette.updateFold(by(palette), looked, seconds);
    timeline.updateFold(by(timeline), false, seconds);
  }

  /** Whether the eyes are on a panel, to a cosine. */
  private looked(panel: Panel, cosine: number): boolean {
    const { headInRig, gaze } = this.rig;
    if (!panel.mesh.visible) return false;
    const middle = panel.middle(this.middle).sub(headInRig);
    return middle.dot(gaze) > cosine * middle.length();
  }

  /** Move a panel with the pointer that holds its bar. */
  carry(panel: Panel, by: Carrier): void {
    this.placement.carry(panel, by);
  }

  dispose(): void {
    for (const part of [...this.all, this.questionPlace]) part.dispose();
  }
}
