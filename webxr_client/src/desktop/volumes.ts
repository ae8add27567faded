/** Boxes under the mouse, the box tool's and the clip box: their handles are shown, found and dragged. */
import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DynamicDrawUsage,
  Group,
  LineBasicMaterial,
  LineSegments,
  type Matrix4,
  Points,
  PointsMaterial,
  type Ray,
  Vector3,
} from 'three';
import { EDGES } from '../boxes/drawing';
import { gizmo } from '../boxes/volume';
import { clip } from '../tools/clip';
import type { Viewer } from '../cloud/picture/viewer';
import { boxDraft, dragged, type Handle, matrixOf, placeOf, type Volume } from '../tools/volume';
import { brushColor } from '../tools/brush';
import type { Aim } from '../view/aim';

/** A handle is met so near to its middle, pixels. */
const NEAR = 11;
const CLIP_COLOR = '#ffc857';

const FACES: readonly Handle[] = ([0, 1, 2] as const).flatMap((axis) =>
  ([-1, 1] as const).map((side): Handle => ({ axis, side })),
);
const ALL: readonly Handle[] = [...FACES, 'move', 'turn'];

interface Edited {
  readonly volume: Volume;
  readonly handles: readonly Handle[];
  readonly color: string;
  readonly write: (volume: Volume) => void;
  /** Called at the end of a drag. */
  readonly done?: () => void;
}

/** Return the boxes that can be changed now, the one on top first. */
function edited(room: Matrix4): Edited[] {
  const found: Edited[] = [];
  const draft = boxDraft.peek();
  if (draft) {
    const write = (volume: Volume): void => void (boxDraft.value = volume);
    found.push({ volume: draft, handles: ALL, color: brushColor(), write });
  }
  const object = gizmo(room);
  if (object) found.push({ ...object, handles: ALL });
  const box = clip.peek();
  if (box) {
    const { slab } = box;
    const handles =
      slab === null ? ALL : FACES.filter((face) => typeof face === 'object' && face.axis === slab);
    const write = (volume: Volume): void => void (clip.value = { ...box, volume });
    found.push({ volume: box.volume, handles, color: CLIP_COLOR, write });
  }
  return found;
}

interface Grip {
  readonly edited: Edited;
  readonly handle: Handle;
  readonly from: Ray;
}

export class VolumeHandles {
  private readonly views: readonly VolumeView[];
  private grip: Grip | null = null;

  constructor(
    private readonly viewer: Viewer,
    private readonly aim: Aim,
  ) {
    this.views = Array.from({ length: 3 }, () => new VolumeView(viewer.world));
  }

  /** Before each picture. */
  update(): void {
    const now = edited(this.viewer.room.matrix);
    this.views.forEach((view, i) => {
      const one = now[i];
      if (one) view.show(one.volume, one.handles, one.color, this.viewer.renderer.getPixelRatio());
      else view.hide();
    });
  }

  /** Return the handle under the cursor, or null. */
  under(): { readonly edited: Edited; readonly handle: Handle } | null {
    let best = NEAR;
    let found: { edited: Edited; handle: Handle } | null = null;
    for (const one of edited(this.viewer.room.matrix)) {
      for (const handle of one.handles) {
        const distance = this.pixelsTo(placeOf(one.volume, handle));
        if (distance < best) {
          best = distance;
          found = { edited: one, handle };
        }
      }
    }
    return found;
  }

  private pixelsTo(place: Vector3): number {
    const { camera, canvas } = this.viewer;
    const { x, y, z } = place.project(camera);
    if (z > 1) return Infinity;
    const [u, v] = [((x + 1) / 2) * canvas.clientWidth, ((1 - y) / 2) * canvas.clientHeight];
    return Math.hypot(u - this.aim.x, v - this.aim.y);
  }

  /** Grab the handle under the cursor; false if there is none. */
  grab(): boolean {
    const found = this.under();
    this.grip = found && { ...found, from: this.aim.roomRay() };
    return found !== null;
  }

  drag(): void {
    if (!this.grip) return;
    const { edited: one, handle, from } = this.grip;
    one.write(dragged(one.volume, handle, from, this.aim.roomRay()));
  }

  release(): void {
    this.grip?.edited.done?.();
    this.grip = null;
  }
}

/** Pixels across a handle. */
const SIZE = 10;
const MOST_HANDLES = 8;

/** A box on screen: its edges, and the handles it is changed by. */
class VolumeView {
  private readonly group = new Group();
  private readonly edges: LineSegments<BufferGeometry, LineBasicMaterial>;
  private readonly knobs: Points<BufferGeometry, PointsMaterial>;
  private readonly rims: Points<BufferGeometry, PointsMaterial>;

  constructor(parent: { add(object: Group): unknown }) {
    const line = new LineBasicMaterial({ transparent: true, opacity: 0.9 });
    this.edges = new LineSegments(places(EDGES.length + 2), line);
    const dots = places(MOST_HANDLES);
    this.rims = new Points(dots, dotsOf(SIZE + 4, '#05070a'));
    this.knobs = new Points(dots, dotsOf(SIZE, '#ffffff'));
    this.rims.renderOrder = 20;
    this.knobs.renderOrder = 21;
    this.group.add(this.edges, this.rims, this.knobs);
    for (const part of this.group.children) part.frustumCulled = false;
    this.hide();
    parent.add(this.group);
  }

  show(volume: Volume, handles: readonly Handle[], color: string, ratio: number): void {
    const line = this.edges.geometry.getAttribute('position') as BufferAttribute;
    const matrix = matrixOf(volume);
    const corner = new Vector3();
    EDGES.forEach((number, i) => {
      const side = (bit: number): number => (number & bit ? 1 : -1);
      corner.set(side(1), side(2), side(4)).applyMatrix4(matrix);
      line.setXYZ(i, ...corner.toArray());
    });
    const turns = handles.includes('turn');
    const from = placeOf(volume, { axis: 0, side: 1 });
    line.setXYZ(EDGES.length, ...from.toArray());
    line.setXYZ(EDGES.length + 1, ...(turns ? placeOf(volume, 'turn') : from).toArray());
    line.needsUpdate = true;
    const dots = this.knobs.geometry.getAttribute('position') as BufferAttribute;
    handles.forEach((handle, i) => dots.setXYZ(i, ...placeOf(volume, handle).toArray()));
    dots.needsUpdate = true;
    this.knobs.geometry.setDrawRange(0, handles.length);
    this.edges.material.color = this.knobs.material.color = new Color(color);
    this.knobs.material.size = SIZE * ratio;
    this.rims.material.size = (SIZE + 4) * ratio;
    this.group.visible = true;
  }

  hide(): void {
    this.group.visible = false;
  }
}

function places(count: number): BufferGeometry {
  const attribute = new BufferAttribute(new Float32Array(3 * count), 3);
  attribute.setUsage(DynamicDrawUsage);
  return new BufferGeometry().setAttribute('position', attribute);
}

function dotsOf(size: number, color: string): PointsMaterial {
  return new PointsMaterial({ size, color, sizeAttenuation: false, depthTest: false, transparent: true }); // prettier-ignore
}
