/** Hints at the controls of a hand: a few words each with a line to its control, until it has been used. */
import { Box3, Group, Matrix4, Vector3 } from 'three';
import { faceEyes } from '../drawing/facing';
import { Ribbon } from '../drawing/ribbon';
import { Sign } from '../drawing/sign';
import { SIZES } from '../drawing/sizes';
import { INK } from '../drawing/ui';
import type { Spots } from '../input/kind';
import { tipsFor, type Lessons, type Part, type Tip } from '../input/lessons';
import type { Pointer } from '../input/pointer';
import type { Rig } from '../moving/rig';
import type { Panel } from '../panels/panel';

const FADE_PER_SECOND = 2;
/** Most hints at once: a person reads no more. */
const MOST: Record<Part, number> = { brush: 2, other: 1 };
/** Metres from the middle of the hand to the words, and from one line of words to the next. */
const [BESIDE, PITCH] = [0.06, 1.95 * SIZES.tips.em];
/** Metres: end of a line before its control, and from a pad's middle, where colours are. */
const [BEFORE, EDGE] = [0.004, 0.01];
/** Metres that words may be moved over their hand: moved more, they lie on its inner side, and return below half. */
const SLACK = 0.02;
/** Share of the way to the eyes by which the words lie before the hand: it hides none of them. */
const NEARER = 0.12;
/** Metres outside the picture at which a hand has no words. */
const OUTSIDE_METRES = 0.25;
/** Number of moves to bring words inside, and the share of the missing distance of each move. */
const [PASSES, GAIN] = [6, 0.5];
const CORNERS = 4;

/** A hint that is shown, or fades. */
interface Row {
  readonly sign: Sign;
  readonly line: Ribbon;
  tip: Tip | null;
  opacity: number;
}

export class Tips {
  readonly group = new Group();
  /** Sides of all words, in the group's own space. */
  readonly box = new Box3();
  private tips: readonly Tip[] = [];
  private rows: Row[] = [];
  private readonly facing = { right: 0, up: 0, distance: SIZES.tips.distance };
  private readonly shift = new Float64Array(2);
  /** Side of the hand on which the words lie: 1 is to the right. */
  private aside = 1;
  private readonly corner = new Vector3();
  private readonly toGroup = new Matrix4();
  /** Sides of the words and of a panel as the eyes see them. */
  private readonly own = new Float64Array(4);
  private readonly others = new Float64Array(4);

  constructor(
    private readonly lessons: Lessons,
    private readonly hand: Pointer,
    private readonly spots: Spots,
  ) {}

  /** Rewrite the hints of the hand's controls. */
  set(part: Part): void {
    this.clear();
    const { hand, group } = this;
    this.aside = this.outer;
    this.tips = tipsFor(hand.device, part, hand.side === 'left');
    this.rows = Array.from({ length: MOST[part] }, () => {
      const sign = new Sign({ em: SIZES.tips.em, back: INK.back, order: 115, depth: true });
      const line = new Ribbon(2, { order: 114, depth: true });
      group.add(sign.mesh, line.mesh);
      return { sign, line, tip: null, opacity: 0 };
    });
    hand.grip.parent?.add(group);
  }

  /** Once per picture; words hide no part of a panel. */
  update(seconds: Float64Array, shown: boolean, rig: Rig, panels: readonly Panel[]): void {
    const { hand, rows } = this;
    if (rows.length === 0) return;
    this.choose(rig);
    const near = shown && hand.tracked && !this.box.isEmpty() && this.nearPicture(rig);
    if (near) this.keepInside(rig);
    if (near && this.mustTurn(rig)) this.turnOver(rig);
    const bright = near && !this.coversAny(panels, rig);
    const step = Math.min(1, FADE_PER_SECOND * seconds[0]!);
    this.group.visible = hand.grip.visible;
    this.toGroup.copy(this.group.matrix).invert();
    for (let i = 0; i < rows.length; i++) {
      const row = rows[i]!;
      const { opacity } = row;
      const goal = bright && this.wants(row.tip);
      row.opacity = goal ? Math.min(1, opacity + step) : Math.max(0, opacity - step);
      this.draw(row, rig);
    }
  }

  private wants(tip: Tip | null): boolean {
    return tip !== null && this.lessons.wants(tip.lesson, this.hand.device);
  }

  private coversAny(panels: readonly Panel[], rig: Rig): boolean {
    for (let i = 0; i < panels.length; i++) if (this.covers(panels[i]!, rig)) return true;
    return false;
  }

  private draw({ sign, line, tip, opacity }: Row, rig: Rig): void {
    sign.mesh.visible = opacity > 0;
    sign.mesh.material.opacity = line.opacity = opacity;
    // A bare hand has no control that a line could lead to.
    line.show(opacity > 0 && !this.hand.hasPinch ? 2 : 0);
    if (!tip || opacity === 0) return;
    const { x, y } = sign.mesh.position;
    const { x: width } = sign.mesh.scale;
    const { x: right, y: up, z } = this.control(tip);
    // A line to a control below the hand is as deep as it, so that the hand hides its end.
    const below = tip.spot === 'trigger' || tip.spot === 'squeeze';
    const deep = below ? 1 - z / this.corner.copy(rig.headInRig).applyMatrix4(this.toGroup).z : 1;
    line.put(0, (x - (this.aside * width) / 2) * deep, y * deep, below ? z : 0);
    line.put(1, right, up, z + BEFORE);
  }

  /** Let go of hints that have faded, and take the next ones in their place. */
  private choose(rig: Rig): void {
    const { rows, tips } = this;
    let changed = false;
    for (let i = 0; i < rows.length; i++) {
      const row = rows[i]!;
      if (row.opacity > 0 || this.wants(row.tip)) continue;
      changed ||= row.tip !== null;
      row.tip = null;
      for (let k = 0; k < tips.length && row.tip === null; k++)
        if (!this.has(tips[k]!) && this.wants(tips[k]!)) row.tip = tips[k]!;
      changed ||= row.tip !== null;
    }
    if (changed) this.arrange(rig);
  }

  private has(tip: Tip): boolean {
    for (let i = 0; i < this.rows.length; i++) if (this.rows[i]!.tip === tip) return true;
    return false;
  }

  /** Lay the words over the pad, one below the other in the order of their controls: no lines cross. */
  private arrange(rig: Rig): void {
    const { tips, rows, box, corner, aside } = this;
    this.face(rig);
    this.toGroup.copy(this.group.matrix).invert();
    const used = rows.filter(({ tip }) => tip !== null);
    const heights = new Map(used.map((row) => [row, this.control(row.tip!).y]));
    used.sort((a, b) => heights.get(b)! - heights.get(a)! || tips.indexOf(a.tip!) - tips.indexOf(b.tip!)); // prettier-ignore
    box.makeEmpty();
    used.forEach(({ sign: { mesh }, sign, tip }, k) => {
      sign.write(tip!.short);
      const y = (used.length - 0.3 - k) * PITCH;
      mesh.position.set(aside * (BESIDE + mesh.scale.x / 2), y, 0);
      for (const end of [-0.5, 0.5])
        box.expandByPoint(corner.copy(mesh.scale).multiplyScalar(end).setZ(0).add(mesh.position));
    });
  }

  /** The place of a hint's control, in the group's space. */
  private control({ spot }: Tip): Vector3 {
    const { hand, corner, spots, toGroup } = this;
    corner.copy(spots[spot]);
    if (spot === 'pad') corner.x += this.aside * EDGE;
    return corner.applyMatrix4(hand.grip.matrix).applyMatrix4(toGroup);
  }

  /** Whether the hand is in the picture, or near to it. */
  private nearPicture({ inHead, sight }: Rig): boolean {
    const { corner, shift } = this;
    shift.fill(0);
    corner.copy(this.hand.grip.position).applyMatrix4(inHead);
    sight.lacks(corner, shift);
    return corner.z < 0 && Math.hypot(shift[0]!, shift[1]!) < OUTSIDE_METRES;
  }

  /** Place the words beside the hand, moved as far as keeps them in both eyes' pictures. */
  private keepInside(rig: Rig): void {
    const { facing, shift } = this;
    facing.right = facing.up = 0;
    for (let pass = 0; pass <= PASSES; pass++) {
      this.face(rig);
      this.measure(rig);
      const e = this.group.matrix.elements;
      const grown = Math.sqrt(e[0] * e[0] + e[2] * e[2]);
      facing.right += (GAIN * shift[0]!) / grown;
      facing.up += (GAIN * shift[1]!) / grown;
    }
  }

  /** Store the shift of the words into both eyes' pictures; `mirror` −1: on the hand's other side. */
  private measure({ inHead, sight }: Rig, mirror = 1): void {
    this.shift.fill(0);
    for (let k = 0; k < CORNERS; k++)
      sight.lacks(this.wordsCorner(k, mirror).applyMatrix4(inHead), this.shift);
  }

  private get outer(): number {
    return this.hand.side === 'left' ? -1 : 1;
  }

  private mustTurn(rig: Rig): boolean {
    if (this.aside === this.outer) return this.facing.right * this.aside < -SLACK;
    this.measure(rig, -1);
    return Math.abs(this.shift[0]!) < SLACK / 2;
  }

  /** Lay the words on the other side of the hand, where they fade in. */
  private turnOver(rig: Rig): void {
    this.aside *= -1;
    for (const row of this.rows) row.opacity = 0;
    this.arrange(rig);
    this.keepInside(rig);
  }

  /** Turn the words to the eyes, at the pad and as far aside as `facing` tells. */
  private face({ headInRig }: Rig): void {
    const at = this.corner.copy(this.spots.pad).applyMatrix4(this.hand.grip.matrix);
    faceEyes(this.group, at.lerp(headInRig, NEARER), headInRig, this.facing);
  }

  /** A corner of all words, in the headset's own space. */
  private wordsCorner(k: number, mirror = 1): Vector3 {
    const { min, max } = this.box;
    const place = this.corner.set(mirror * (k & 1 ? max.x : min.x), k & 2 ? max.y : min.y, 0);
    return place.applyMatrix4(this.group.matrix);
  }

  /** Whether the eyes see the words before a panel. */
  private covers(panel: Panel, { inHead }: Rig): boolean {
    if (!panel.mesh.visible) return false;
    const { own, others, corner } = this;
    own.fill(-Infinity);
    others.fill(-Infinity);
    for (let k = 0; k < CORNERS; k++) {
      widen(own, this.wordsCorner(k).applyMatrix4(inHead));
      widen(others, panel.middle(corner, k & 1 ? 1 : -1, k & 2 ? 1 : -1).applyMatrix4(inHead));
    }
    for (let k = 0; k < CORNERS; k++) if (own[k]! <= -others[k ^ 1]!) return false;
    return true;
  }

  /** Legible hints, for tests. */
  get shown(): string[] {
    if (!this.group.visible) return [];
    return this.rows.flatMap(({ tip, opacity }) => (tip && opacity > 0 ? tip.text : []));
  }

  clear(): void {
    for (const { sign, line } of this.rows) {
      sign.dispose();
      line.dispose();
    }
    this.group.removeFromParent();
    this.rows = [];
  }
}

/** Extend the sides of the view by a place: tangents to the right, left, up and down. */
function widen(sides: Float64Array, { x, y, z }: Vector3): void {
  const distance = Math.max(1e-3, -z);
  sides[0] = Math.max(sides[0]!, x / distance);
  sides[1] = Math.max(sides[1]!, -x / distance);
  sides[2] = Math.max(sides[2]!, y / distance);
  sides[3] = Math.max(sides[3]!, -y / distance);
}
