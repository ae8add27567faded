import type { BufferGeometry, Material, Object3D } from 'three';

/** Remove an object from its scene, and free its GPU memory. */
export function free(
  object: Object3D & { readonly geometry: BufferGeometry; readonly material: Material },
): void {
  object.removeFromParent();
  object.geometry.dispose();
  object.material.dispose();
}
