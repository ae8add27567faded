/** An upright box round each labelled object of the frame on screen. */
import { BoxGeometry, Color, DynamicDrawUsage, InstancedMesh, MeshBasicMaterial, type Matrix4, type Object3D } from 'three'; // prettier-ignore
import { reaches } from '../cloud/points/clipping';
import { boxedLabels } from '../store/boxes';
import { peek } from '../store/watch';
import { colorOf, isShown } from './shown';
import { at, BOX, HALF, type Summary } from './summary';

const MOST = 96;
const EDGES = 12;
/** Metres: edges are bars, since a line of one pixel is a hair in a headset. */
const BAR = 0.004;
/** Space between the points and the box, metres. */
const AIR = 0.01;
/** Fewer points are a speck and no object. */
const FEWEST = 8;

/** Return whether a label's box may have a part in the clip box. */
function meets({ values }: Summary, slot: number, clip: Matrix4): boolean {
  const [box, half] = [at(slot, BOX), at(slot, HALF)];
  const radius = Math.hypot(values[half]!, values[half + 1]!, values[half + 2]!);
  return reaches(clip, values[box]!, values[box + 1]!, values[box + 2]!, radius);
}

export class Boxes {
  /** Boxes on screen. */
  count = 0;
  readonly mesh: InstancedMesh<BoxGeometry, MeshBasicMaterial>;
  /** Of an edge, along the box's axes. */
  private readonly middle = new Float64Array(3);
  private readonly size = new Float64Array(3);

  constructor(world: Object3D) {
    const material = new MeshBasicMaterial({ transparent: true, toneMapped: false });
    this.mesh = new InstancedMesh(new BoxGeometry(1, 1, 1), material, MOST * EDGES);
    this.mesh.instanceMatrix.setUsage(DynamicDrawUsage);
    this.mesh.setColorAt(0, new Color());
    this.mesh.frustumCulled = false;
    this.mesh.visible = false;
    world.add(this.mesh);
  }

  hide(): void {
    this.mesh.visible = false;
    this.count = 0;
  }

  /** Boxes that lie wholly outside `clip` (`T_cube_room`), and of labels that are boxed, are left out. */
  show(summary: Summary, clip: Matrix4 | null): void {
    let bars = 0;
    const boxed = peek(boxedLabels);
    this.count = 0;
    for (let slot = 0; slot < summary.labels.length && this.count < MOST; slot++) {
      const label = summary.labels[slot]!;
      if (summary.count[slot]! < FEWEST || !isShown(label) || boxed.has(label)) continue;
      if (clip && !meets(summary, slot, clip)) continue;
      this.count += 1;
      const color = colorOf(label);
      for (let edge = 0; edge < EDGES; edge++, bars++) {
        this.place(summary, slot, edge, 16 * bars);
        this.mesh.setColorAt(bars, color);
      }
    }
    this.mesh.count = bars;
    this.mesh.visible = bars > 0;
    this.mesh.instanceMatrix.needsUpdate = true;
    this.mesh.instanceColor!.needsUpdate = true;
  }

  /** One edge as a stretched cube, its matrix at `to`: four edges along each axis. */
  private place({ values, yaw }: Summary, slot: number, edge: number, to: number): void {
    const { middle, size } = this;
    const along = edge >> 2;
    for (let axis = 0; axis < 3; axis++) {
      const half = values[at(slot, HALF + axis)]! + AIR;
      // The first bit is the side along one of the other axes, the second bit along the other.
      const bit = axis === (along + 1) % 3 ? 1 : 2;
      middle[axis] = axis === along ? 0 : edge & bit ? half : -half;
      size[axis] = axis === along ? 2 * half + BAR : BAR;
    }
    const cos = Math.cos(yaw[slot]!);
    const sin = Math.sin(yaw[slot]!);
    const u = middle[0]!;
    const v = middle[2]!;
    // Column by column; the numbers that stay zero are written nowhere.
    const m = this.mesh.instanceMatrix.array;
    m[to] = cos * size[0]!;
    m[to + 2] = -sin * size[0]!;
    m[to + 5] = size[1]!;
    m[to + 8] = sin * size[2]!;
    m[to + 10] = cos * size[2]!;
    m[to + 12] = values[at(slot, BOX)]! + cos * u + sin * v;
    m[to + 13] = values[at(slot, BOX + 1)]! + middle[1]!;
    m[to + 14] = values[at(slot, BOX + 2)]! - sin * u + cos * v;
    m[to + 15] = 1;
  }
}
