/** Whether a depth image is drawn as a surface: by itself where its points would show gaps. */
import { Matrix4, Vector4, type Camera } from 'three';
import type { DepthImage } from '../../../net/chunk/segment';
import type { Lattice } from '../../../protocol/messages';
import type { SurfaceMode } from '../../../store/types';
import { raysOf, stepsOf } from './slot';

/** Pixels on screen between neighbours from which on a surface is drawn, and below which no more. */
const [GAPS, NO_GAPS] = [2.2, 1.8];
/** Pixels of the image that are looked at along each side, and the share of these in view that counts. */
const SAMPLES = 16;
const SHARE = 1 / 8;

export class SurfaceChoice {
  mode: SurfaceMode = 'auto';
  on = false;
  private readonly clipFromPixel = new Matrix4();
  private readonly at = new Vector4();
  private pixels: ReturnType<typeof pixelsOf> | null = null;

  /** Another recording. */
  reset(): void {
    this.pixels = null;
  }

  /** Choose for a picture so high, pixels; `sceneFromLocal` of the frame. */
  update(
    image: DepthImage | null,
    camera: Camera,
    sceneFromLocal: Matrix4,
    height: number,
  ): boolean {
    if (!image || this.mode !== 'auto')
      return (this.on = image !== null && this.mode === 'surface');
    const { clipFromPixel } = this;
    const { rays, spacing } = (this.pixels ??= pixelsOf(image.lattice));
    clipFromPixel.multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    clipFromPixel.multiply(sceneFromLocal).multiply(rays);
    const zoom = Math.cbrt(Math.abs(sceneFromLocal.determinant()));
    const scale = 0.5 * height * camera.projectionMatrix.elements[5] * zoom;
    const most = this.on ? NO_GAPS : GAPS;
    return (this.on = this.hasGaps(image, (spacing * scale) / most));
  }

  /** Return whether enough visible pixels are nearer than `reach` metres for each unit of depth. */
  private hasGaps({ lattice: { width, height }, depths }: DepthImage, reach: number): boolean {
    const { at, clipFromPixel } = this;
    let inView = 0;
    let gaps = 0;
    for (let k = 0; k < SAMPLES * SAMPLES; k++) {
      const column = Math.floor((((k % SAMPLES) + 0.5) * width) / SAMPLES);
      const row = Math.floor(((Math.floor(k / SAMPLES) + 0.5) * height) / SAMPLES);
      const depth = depths[row * width + column]!;
      const { x, y, w } = at.set(1, depth, depth * column, depth * row).applyMatrix4(clipFromPixel);
      if (depth === 0 || Math.abs(x) > w || Math.abs(y) > w) continue;
      inView += 1;
      if (reach * depth > w) gaps += 1;
    }
    return gaps > SHARE * inView;
  }
}

function pixelsOf(lattice: Lattice) {
  return { rays: raysOf(lattice), spacing: stepsOf(lattice).x };
}
