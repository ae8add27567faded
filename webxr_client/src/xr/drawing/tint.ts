/**
 * Colours that lie on the vertices: materials that are alike are told apart by nothing that three.js
 * would have to send for each thing it draws.
 */
import { Color, Float32BufferAttribute, type BufferGeometry } from 'three';

const scratch = new Color();

/** Give all vertices of a geometry a colour and an opacity. */
export function tint(
  geometry: BufferGeometry,
  color: string | number,
  opacity = 1,
): BufferGeometry {
  const { r, g, b } = scratch.set(color);
  const { count } = geometry.getAttribute('position');
  if (!geometry.hasAttribute('color')) {
    geometry.setAttribute('color', new Float32BufferAttribute(new Float32Array(4 * count), 4));
  }
  const colors = geometry.getAttribute('color');
  for (let i = 0; i < count; i++) colors.setXYZW(i, r, g, b, opacity);
  colors.needsUpdate = true;
  return geometry;
}
