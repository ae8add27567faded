/** Rows of a panel that pulse, without drawing the panel anew. */
import { free } from '../../common/free';
import { AdditiveBlending, BufferGeometry, DynamicDrawUsage, Float32BufferAttribute, Mesh, MeshBasicMaterial } from 'three'; // prettier-ignore
import { tint } from './tint';

/** Metres, on the panel. */
export interface Patch {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

/** Text below stays legible: more light would wash it out. */
const BRIGHTEST = 0.14;

/** A quad's corners as two triangles. */
const CORNERS = [0, 1, 2, 2, 1, 3] as const;

export class Glow {
  readonly mesh: Mesh<BufferGeometry, MeshBasicMaterial>;
  /** Patches that are placed. */
  count = 0;

  constructor(private readonly most: number) {
    const geometry = new BufferGeometry();
    const places = new Float32BufferAttribute(new Float32Array(3 * CORNERS.length * most), 3);
    geometry.setAttribute('position', places.setUsage(DynamicDrawUsage));
    tint(geometry, 0xffc966, 0);
    const material = new MeshBasicMaterial({
      vertexColors: true,
      transparent: true,
      blending: AdditiveBlending,
      depthWrite: false,
      toneMapped: false,
    });
    this.mesh = new Mesh(geometry, material);
    this.mesh.renderOrder = 101;
    this.mesh.frustumCulled = false;
    this.mesh.visible = false;
  }

  place(patches: readonly Patch[]): void {
    this.count = Math.min(patches.length, this.most);
    const { geometry } = this.mesh;
    const position = geometry.getAttribute('position');
    for (let i = 0; i < this.count; i++) {
      const { x, y, width, height } = patches[i]!;
      CORNERS.forEach((corner, k) => {
        const [right, up] = [corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5];
        position.setXYZ(CORNERS.length * i + k, x + right * width, y + up * height, 0.0005);
      });
    }
    position.needsUpdate = true;
    geometry.setDrawRange(0, CORNERS.length * this.count);
  }

  pulse(strength: number): void {
    const { mesh } = this;
    mesh.visible = strength > 0 && this.count > 0;
    if (!mesh.visible) return;
    const colors = mesh.geometry.getAttribute('color');
    const { array } = colors;
    for (let i = 3; i < array.length; i += 4) array[i] = BRIGHTEST * strength;
    colors.needsUpdate = true;
  }

  dispose(): void {
    free(this.mesh);
  }
}
