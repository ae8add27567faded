/** The brush on the surface: a ring that faces the eye, in the label's colour. */
import { BufferGeometry, Color, Float32BufferAttribute, LineBasicMaterial, LineLoop, type PerspectiveCamera, type Vector3 } from 'three'; // prettier-ignore

const CORNERS = 64;

export class BrushRing {
  readonly object: LineLoop<BufferGeometry, LineBasicMaterial>;

  constructor() {
    const corners: number[] = [];
    for (let i = 0; i < CORNERS; i++) {
      const angle = (i / CORNERS) * 2 * Math.PI;
      corners.push(Math.cos(angle), Math.sin(angle), 0);
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new Float32BufferAttribute(corners, 3));
    const material = new LineBasicMaterial({ depthTest: false, transparent: true, opacity: 0.95 });
    this.object = new LineLoop(geometry, material);
    this.object.renderOrder = 10;
    this.object.frustumCulled = false;
    this.object.visible = false;
  }

  show(at: Vector3, radius: number, color: Color, camera: PerspectiveCamera): void {
    this.object.position.copy(at);
    this.object.quaternion.copy(camera.quaternion);
    this.object.scale.setScalar(radius);
    this.object.material.color.copy(color);
    this.object.visible = true;
  }

  hide(): void {
    this.object.visible = false;
  }
}
