/**
 * The ring of colours round the pad of the hand that paints: the labels that a push would take.  While
 * no thumb is there, a small one marks the pad.
 */
import { CircleGeometry, Group, Mesh, MeshBasicMaterial, RingGeometry, Vector3, type BufferGeometry } from 'three'; // prettier-ignore
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import { free } from '../../common/free';
import { faceEyes } from '../drawing/facing';
import { Sign } from '../drawing/sign';
import { SIZES } from '../drawing/sizes';
import { tint } from '../drawing/tint';
import type { Spots } from '../input/kind';
import { ORDER } from '../input/model';
import { type Choice, labelBeside, type UpDown } from '../input/up-down';
import type { Rig } from '../moving/rig';
import type { Body } from './body';

/** Metres from the pad's middle: the disc of the active label, the ring, and the arc that is marked. */
const [DISC, INNER, OUTER, MARKED] = [0.01, 0.024, 0.037, 0.044];
/** Opacity of the ring's colours beside a marked one. */
const DIMMED = 0.45;
/** Degrees of the arcs, from the right and counterclockwise, by steps in the palette. */
const ARCS: readonly (readonly [steps: number, from: number, degrees: number])[] = [
  [-1, 50, 80], [1, 230, 80], [-2, 0, 50], [2, 310, 50], [-3, 130, 50], [3, 180, 50],
]; // prettier-ignore
/** Degrees between two arcs. */
const GAP = 4;
const DEGREE = Math.PI / 180;
/** Turn of the ring from lying on the pad towards the eyes. */
const TILT = 35 * DEGREE;
/** Size of the ring on the pad while no thumb is there, and its height and the large one's over it, metres. */
const [SMALL, ON, OVER] = [0.45, 0.0015, 0.02];
const UP = new Vector3(0, 1, 0);
/** The name is where no hints of the hand are. */
const NAME = { up: 0.03, distance: SIZES.tips.distance };
const BESIDE = { left: { ...NAME, right: 0.09 }, right: { ...NAME, right: -0.09 } };

export class LabelRing {
  /** Holds the name of the marked label, in the headset's own space. */
  readonly group = new Group();
  private readonly mesh: Mesh<BufferGeometry, MeshBasicMaterial>;
  private readonly sign = new Sign({ em: SIZES.tips.em, order: 126 });
  private readonly at = new Vector3();
  /** Content of the drawn ring; another content is drawn again. */
  private palette: readonly Choice[] | null = null;
  private active = -1;
  private marked = NaN;
  private shown = false;

  constructor(private readonly upDown: UpDown) {
    const look = { vertexColors: true, transparent: true, toneMapped: false };
    this.mesh = new Mesh(new CircleGeometry(), new MeshBasicMaterial(look));
    this.mesh.renderOrder = ORDER + 1;
    this.mesh.frustumCulled = false;
    this.group.add(this.sign.mesh);
  }

  /** Once per picture. */
  update(body: Body | null, rig: Rig): void {
    const { mesh, upDown, at } = this;
    const palette = upDown.list;
    const least = upDown.shown ? 2 : 1;
    mesh.visible = palette.length >= least && (body?.pointer.device.pad ?? 'none') !== 'none';
    this.sign.mesh.visible = mesh.visible && (upDown.marked !== 0 || upDown.answers !== null);
    if (!body || !mesh.visible) return;
    const { grip, side } = body.pointer;
    if (mesh.parent !== grip) grip.add(mesh);
    this.lay(body.spots);
    this.draw(palette, upDown.active);
    if (!this.sign.mesh.visible) return;
    at.copy(mesh.position).applyMatrix4(grip.matrix);
    faceEyes(this.group, at, rig.headInRig, BESIDE[side === 'left' ? 'left' : 'right']);
  }

  /** On the pad, or over it and leant towards the eyes. */
  private lay({ pad, up }: Spots): void {
    const { mesh, upDown } = this;
    mesh.position.copy(pad).addScaledVector(up, upDown.shown ? OVER : ON);
    mesh.quaternion.setFromUnitVectors(UP, up);
    if (upDown.shown) mesh.rotateX(TILT);
    mesh.scale.setScalar(upDown.shown ? 1 : SMALL);
  }

  private draw(palette: readonly Choice[], active: number): void {
    const { marked, shown: thumb } = this.upDown;
    const same = palette === this.palette && active === this.active;
    if (same && marked === this.marked && thumb === this.shown) return;
    Object.assign(this, { palette, active, marked, shown: thumb });
    const { mesh } = this;
    const direction = Math.sign(marked);
    // Held on, the ring turns: the marked label stays where the thumb is.
    const middle = labelBeside(palette, active, marked - direction);
    const labelAt = (steps: number): Choice =>
      palette.find(({ id }) => id === labelBeside(palette, middle, steps))!;
    const others = palette.length - 1;
    const shown = ARCS.slice(0, thumb ? Math.max(2, others) : 2 * Math.min(1, others));
    const arcs = shown.map(([steps, from, degrees]) => {
      const on = steps === direction;
      const outer = on ? MARKED : OUTER;
      const sweep = (degrees - GAP) * DEGREE;
      const arc = new RingGeometry(INNER, outer, 12, 1, (from + GAP / 2) * DEGREE, sweep);
      return tint(arc, labelAt(steps).color, on || direction === 0 ? 1 : DIMMED);
    });
    const parts = [tint(new CircleGeometry(DISC, 24), labelAt(0).color), ...arcs];
    mesh.geometry.dispose();
    mesh.geometry = mergeGeometries(parts).rotateX(-Math.PI / 2);
    for (const part of parts) part.dispose();
    if (!this.sign.mesh.visible) return;
    const named = direction === 0 ? [-1, 1] : [direction];
    this.sign.write(named.map((at) => `${at < 0 ? '↑' : '↓'} ${labelAt(at).name}`).join('\n'));
  }

  dispose(): void {
    free(this.mesh);
    this.sign.dispose();
    this.group.removeFromParent();
  }
}
