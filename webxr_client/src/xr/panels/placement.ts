/** Places of panels in the room: low before the eyes, or where a ray carries them. */
import { MathUtils, type Object3D, Vector3 } from 'three';
import { faceEyes, type Facing } from '../drawing/facing';
import type { Panel } from './panel';
import type { Rig } from '../moving/rig';
import { MODEL } from '../moving/world';
import { SIZES } from '../drawing/sizes';

const DEGREE = Math.PI / 180;

/** Angles in radians, lengths in metres. */
export const PLACEMENT = {
  /** Metres from the eyes to a panel's middle; farther panels grow.  A detached palette is nearer. */
  distance: 0.85,
  nearer: 0.7,
  /** The lower edge of a panel that hangs, where its handle is, below the eyes' height … */
  edge: 43 * DEGREE,
  /** … and at least so far above the lower edge of the picture. */
  inside: 2 * DEGREE,
  /** The middle of a question below the eyes' height: above, where it hides nothing to be mended. */
  question: -12 * DEGREE,
  /** From an object to the middle of the question beside it, and the farthest that it hangs aside. */
  besideObject: 23 * DEGREE,
  farAside: 40 * DEGREE,
  /** To the left of straight ahead, where a palette without a hand hangs: its handle is beside the timeline's. */
  beside: 20.5 * DEGREE,
  /** Height of a handle and the gap above it, and from a model to panels beside it. */
  handle: 4.5 * DEGREE,
  apart: 1 * DEGREE,
  /** The middle of an added panel below the eyes' height: above, so that the points stay in sight. */
  added: -17 * DEGREE,
  /** As near to the eyes, and as far from them, as a carried panel comes. */
  nearest: 0.45,
  farthest: 3,
} as const;

const FACING: Facing = { right: 0, up: 0, distance: PLACEMENT.distance };
const BESIDE: Facing = { right: 0, up: 0, distance: SIZES.palette.distance };

/**
 * Place of a panel's lower edge: low in the picture, over a handle that is there, a handle's height
 * under a model, or all of the panel under that.
 */
export type PanelLevel = 'low' | 'raised' | 'between' | 'under';

/**
 * The place that is seen from `eyes` so far to the left and so far down, radians, of where `yaw`
 * looks; all in the headset's own space, where heights count from the eyes alone.
 */
function seenAt(
  eyes: Vector3,
  yaw: number,
  left: number,
  down: number,
  distance: number,
  out: Vector3,
): Vector3 {
  const level = distance * Math.cos(down);
  return out.set(
    eyes.x - Math.sin(yaw + left) * level,
    eyes.y - distance * Math.sin(down),
    eyes.z - Math.cos(yaw + left) * level,
  );
}

export class Placement {
  /** Direction of the eyes when panels were last laid, in the headset's own space. */
  private yaw = 0;
  private readonly at = new Vector3();
  private readonly middle = new Vector3();
  private readonly held = new Vector3();

  constructor(private readonly rig: Rig) {}

  /** Take the way that one looks now as straight ahead. */
  face(): void {
    const { ahead, group } = this.rig;
    this.yaw = Math.atan2(-ahead.x, -ahead.z) - group.rotation.y;
  }

  /** Lay a panel before the person, so far below the eyes. */
  layBefore(panel: Object3D, below: number): void {
    this.hang(panel, 0, below, FACING);
  }

  /**
   * Lay a panel beside an object or a model of so many metres' radius, on the side that is nearer to
   * straight ahead; see `seenAt`.
   */
  layBeside({ mesh, size }: Panel, object: Vector3, radius = 0): void {
    const offset = this.held.subVectors(object, this.rig.headInRig);
    const turn = Math.atan2(-offset.x, -offset.z) - this.yaw;
    const left = Math.atan2(Math.sin(turn), Math.cos(turn));
    const { distance, apart, besideObject } = PLACEMENT;
    const half = Math.asin(Math.min(1, radius / Math.max(1e-6, Math.hypot(offset.x, offset.z))));
    const clear = half + Math.atan2(size.width / 2, distance) + apart;
    const aside = left + (left > 0 ? -1 : 1) * Math.max(besideObject, radius && clear);
    if (Math.abs(aside) > PLACEMENT.farAside) return;
    const down = -Math.asin(offset.y / Math.max(1e-6, offset.length()));
    const { question } = PLACEMENT;
    this.hang(mesh, aside, MathUtils.clamp(down, question, -question), FACING);
  }

  /** Hang the timeline straight ahead. */
  hangTimeline({ mesh, size }: Panel, level: PanelLevel = 'low'): void {
    this.hang(mesh, 0, this.middleOf(size.height / FACING.distance, level), FACING);
  }

  /** Hang the palette, its handle beside that of the timeline. */
  hangPalette({ mesh, size }: Panel, level: PanelLevel = 'low'): void {
    const { beside, nearer } = PLACEMENT;
    this.hang(mesh, beside, this.middleOf(size.height / BESIDE.distance, level), BESIDE, nearer);
  }

  /** Return how far below the eyes' height the middle of a panel hangs; `height`: a share of its distance. */
  private middleOf(height: number, level: PanelLevel): number {
    const half = Math.atan(height / 2);
    const { edge, inside, handle } = PLACEMENT;
    const lowest = Math.min(edge, this.rig.sight.down - inside);
    const under = MODEL.below + handle;
    return (
      { low: lowest, raised: lowest - handle, between: under, under: under + 2 * half }[level] -
      half
    );
  }

  private hang(
    panel: Object3D,
    left: number,
    down: number,
    facing: Facing,
    distance: number = PLACEMENT.distance,
  ): void {
    const { headInRig } = this.rig;
    faceEyes(panel, seenAt(headInRig, this.yaw, left, down, distance, this.at), headInRig, facing);
  }

  /** Move a panel held by its bar with the ray, facing the eyes. */
  carry(panel: Panel, by: { readonly origin: Vector3; readonly direction: Vector3 }): void {
    const { at, middle, rig } = this;
    const { headInRig } = rig;
    const { matrix } = panel.mesh;
    at.copy(by.origin).addScaledVector(by.direction, panel.distance[0]!);
    rig.group.worldToLocal(at).sub(headInRig);
    at.clampLength(PLACEMENT.nearest, PLACEMENT.farthest).add(headInRig);
    middle.copy(at);
    // A move to keep the held point on the ray changes the direction to the eyes: a second pass.
    for (let pass = 0; pass < 2; pass++) {
      faceEyes(panel.mesh, middle, headInRig, FACING);
      this.held.set(panel.heldAt.x, panel.heldAt.y, 0).applyMatrix4(matrix);
      middle.add(at).sub(this.held);
    }
    matrix.setPosition(middle);
  }
}

/** The palette's place: over a hand, beside the timeline's handle, or nowhere. */
type Spot = 'hand' | 'beside' | 'away';

/** Seconds out of sight after which a hand counts as missing. */
const MISSING = 0.7;
/** Cosine between the palm and the eyes from which it is turned to them, and below which no more. */
const [FACING_FROM, FACING_UNTIL] = [0.75, 0.5];
/** Seconds for which a palm is turned before it asks for the palette: a system gesture pinches earlier. */
const REQUEST_SECONDS = 0.4;

export class PaletteSpot {
  /** In this picture a palm turned to the eyes has asked for it. */
  isRequested = false;
  private turned = false;
  private readonly turnedFor = new Float64Array(1);
  /** Seconds since a hand was there to hold it. */
  private readonly missing = Float64Array.of(MISSING);

  /**
   * Once per picture; `palm`: how much the holding hand's palm faces the eyes, while it is there and
   * pinches nothing.
   */
  update(isPresent: boolean, painting: boolean, palm: number, seconds: Float64Array): Spot {
    this.missing[0] = isPresent ? 0 : this.missing[0]! + seconds[0]!;
    const turned = isPresent && palm > (this.turned ? FACING_UNTIL : FACING_FROM);
    const before = this.turnedFor[0]!;
    this.turnedFor[0] = turned ? before + seconds[0]! : 0;
    this.isRequested = before < REQUEST_SECONDS && this.turnedFor[0] >= REQUEST_SECONDS;
    this.turned = turned;
    if (painting) return 'away';
    if (isPresent) return 'hand';
    return this.handless ? 'beside' : 'away';
  }

  /** No hand is there to hold it. */
  get handless(): boolean {
    return this.missing[0]! >= MISSING;
  }
}
