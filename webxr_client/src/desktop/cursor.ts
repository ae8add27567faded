/** The brush on the surface: a ring that faces the eye, in the label's colour, edged dark. */
import { Color, Group, Mesh, MeshBasicMaterial, RingGeometry, type PerspectiveCamera, type Vector3 } from 'three'; // prettier-ignore

const CORNERS = 72;
/** Pixels of the line, and of the dark edge on either side of it. */
const LINE = 2;
const EDGE = 1;

export class BrushRing {
  readonly object = new Group();
  private readonly line = ring(new Color(0xffffff), 11, 1);
  private readonly edge = ring(new Color(0x05070a), 10, 0.55);
  private thickness = 0;

  constructor() {
    this.object.add(this.edge, this.line);
    this.object.visible = false;
  }

  /** `pixel`: metres that one pixel covers at the ring's distance. */
  show(at: Vector3, radius: number, color: Color, camera: PerspectiveCamera, pixel: number): void {
    this.object.position.copy(at);
    this.object.quaternion.copy(camera.quaternion);
    this.object.scale.setScalar(radius);
    this.line.material.color.copy(color);
    this.shape(Math.min(0.5, pixel / radius));
    this.object.visible = true;
  }

  hide(): void {
    this.object.visible = false;
  }

  /** Lines as thick on screen at any distance; new geometry only when that changes visibly. */
  private shape(pixel: number): void {
    if (Math.abs(pixel / this.thickness - 1) < 0.1) return;
    this.thickness = pixel;
    this.line.geometry.dispose();
    this.edge.geometry.dispose();
    this.line.geometry = new RingGeometry(1 - LINE * pixel, 1, CORNERS);
    this.edge.geometry = new RingGeometry(1 - (LINE + EDGE) * pixel, 1 + EDGE * pixel, CORNERS);
  }
}

function ring(color: Color, order: number, opacity: number): Mesh<RingGeometry, MeshBasicMaterial> {
  const material = new MeshBasicMaterial({ color, opacity, transparent: true, depthTest: false });
  const mesh = new Mesh(new RingGeometry(0.95, 1, CORNERS), material);
  mesh.renderOrder = order;
  mesh.frustumCulled = false;
  return mesh;
}
