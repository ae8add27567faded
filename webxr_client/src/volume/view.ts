/** A box on screen: its edges, and the handles it is changed by. */
import { BufferAttribute, BufferGeometry, Color, DynamicDrawUsage, Group, LineBasicMaterial, LineSegments, Points, PointsMaterial, Vector3 } from 'three'; // prettier-ignore
import { matrixOf, placeOf, type Handle, type Volume } from './volume';

/** Pixels across a handle. */
const SIZE = 10;
/** Corners two and two, by the bits of their numbers: the twelve edges. */
const EDGES = [0, 1, 2, 3, 4, 5, 6, 7, 0, 2, 1, 3, 4, 6, 5, 7, 0, 4, 1, 5, 2, 6, 3, 7];
const MOST_HANDLES = 8;

export class VolumeView {
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
