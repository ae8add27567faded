/** An object without points that compiles the points' program before the first of them come. */
import { BufferGeometry, Points, type WebGLRenderer } from 'three';
import { ChunkTable, pointMaterial, type PointUniforms } from './material';

export function noPoints(renderer: WebGLRenderer, uniforms: PointUniforms): Points {
  const points = new Points(
    new BufferGeometry(),
    pointMaterial(uniforms, new ChunkTable(renderer), -1),
  );
  points.geometry.setDrawRange(0, 0);
  points.frustumCulled = false;
  return points;
}
