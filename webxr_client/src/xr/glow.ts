/** Rows of a panel that pulse, without drawing the panel anew. */
import { AdditiveBlending, Group, Mesh, MeshBasicMaterial, PlaneGeometry } from 'three';

/** Metres, on the panel. */
export interface Patch {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

/** Text below stays legible: more light would wash it out. */
const BRIGHTEST = 0.14;

export class Glow {
  readonly group = new Group();
  private readonly geometry = new PlaneGeometry(1, 1);
  private readonly material = new MeshBasicMaterial({
    color: 0xffc966,
    transparent: true,
    blending: AdditiveBlending,
    depthTest: false,
    depthWrite: false,
    toneMapped: false,
  });
  /** Patches that are placed. */
  count = 0;

  constructor(most: number) {
    for (let i = 0; i < most; i++) {
      const mesh = new Mesh(this.geometry, this.material);
      mesh.renderOrder = 101;
      mesh.frustumCulled = false;
      mesh.visible = false;
      this.group.add(mesh);
    }
  }

  place(patches: readonly Patch[]): void {
    this.count = Math.min(patches.length, this.group.children.length);
    this.group.children.forEach((mesh, i) => {
      const patch = patches[i];
      mesh.visible = patch !== undefined;
      if (!patch) return;
      mesh.position.set(patch.x, patch.y, 0.0005);
      mesh.scale.set(patch.width, patch.height, 1);
    });
  }

  pulse(strength: number): void {
    this.group.visible = strength > 0 && this.count > 0;
    this.material.opacity = BRIGHTEST * strength;
  }

  dispose(): void {
    this.group.removeFromParent();
    this.geometry.dispose();
    this.material.dispose();
  }
}
