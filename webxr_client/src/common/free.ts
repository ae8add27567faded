import type { BufferGeometry, Material, Object3D } from 'three';

/** Take an object out of its scene, and what it holds of the GPU with it. */
export function free(
  object: Object3D & { readonly geometry: BufferGeometry; readonly material: Material },
): void {
  object.removeFromParent();
  object.geometry.dispose();
  object.material.dispose();
}
