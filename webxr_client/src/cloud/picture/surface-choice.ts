/** Whether a depth image is drawn as a surface: by itself where its points would show gaps. */
import { Matrix4, type Camera } from 'three';
import type { DepthImage } from '../../net/chunk/segment';
import { sidesOf } from '../../net/depth/grid';
import type { SurfaceMode } from '../../store/types';

/** Pixels on screen between neighbours from which on a surface is drawn, and below which no more. */
const [GAPS, NO_GAPS] = [2.2, 1.8];
/** Pixels of the image that are looked at along each side, and the share of these in view that counts. */
const SAMPLES = 16;
const SHARE = 1 / 8;

export class SurfaceChoice {
  mode: SurfaceMode = 'auto';
  on = false;
  private readonly clipFromLocal = new Matrix4();

  /** Choose for a picture so high, pixels; `sceneFromLocal` of the frame. */
  update(
    image: DepthImage | null,
    camera: Camera,
    sceneFromLocal: Matrix4,
    height: number,
  ): boolean {
    if (!image || this.mode !== 'auto')
      return (this.on = image !== null && this.mode === 'surface');
    const { clipFromLocal } = this;
    clipFromLocal.multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    clipFromLocal.multiply(sceneFromLocal);
    const zoom = Math.cbrt(Math.abs(sceneFromLocal.determinant()));
    const scale = 0.5 * height * camera.projectionMatrix.elements[5]! * zoom;
    return (this.on = hasGaps(image, clipFromLocal, scale, this.on ? NO_GAPS : GAPS));
  }
}

/** Whether neighbours lie farther apart than so many pixels, in enough of what is in view. */
function hasGaps(
  { lattice, depths }: DepthImage,
  clip: Matrix4,
  scale: number,
  most: number,
): boolean {
  const { width, height, axis, sign, eye, unit, tangent, pitch } = lattice;
  const e = clip.elements;
  const [a, b] = sidesOf(lattice);
  const apart = Math.sqrt(pitch[0] * pitch[1]) * unit * scale;
  let inView = 0;
  let gaps = 0;
  for (let k = 0; k < SAMPLES * SAMPLES; k++) {
    const column = Math.floor((((k % SAMPLES) + 0.5) * width) / SAMPLES);
    const row = Math.floor(((Math.floor(k / SAMPLES) + 0.5) * height) / SAMPLES);
    const depth = depths[row * width + column]!;
    if (depth === 0) continue;
    at[axis] = eye[axis]! + sign * unit * depth;
    at[a] = eye[a]! + unit * depth * (tangent[0] + pitch[0] * column);
    at[b] = eye[b]! + unit * depth * (tangent[1] + pitch[1] * row);
    const [x, y, z] = at as unknown as [number, number, number];
    const w = e[3] * x + e[7] * y + e[11] * z + e[15];
    const u = e[0] * x + e[4] * y + e[8] * z + e[12];
    const v = e[1] * x + e[5] * y + e[9] * z + e[13];
    if (w <= 0 || Math.abs(u) > w || Math.abs(v) > w) continue;
    inView += 1;
    if (apart * depth > most * w) gaps += 1;
  }
  return gaps > SHARE * inView;
}

const at = new Float64Array(3);
