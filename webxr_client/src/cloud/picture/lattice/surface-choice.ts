/** Whether a depth image is drawn as a surface: by itself where its points would show gaps. */
import { Matrix4, Vector4, type Camera } from 'three';
import type { DepthImage } from '../../../net/chunk/segment';
import type { SurfaceMode } from '../../../store/types';
import { raysMatrix, stepsOf } from './part';

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
  private readonly rays = new WeakMap<DepthImage, Matrix4>();

  /** Choose for a picture so high, pixels; `sceneFromLocal` of the frame. */
  update(
    images: readonly DepthImage[],
    camera: Camera,
    sceneFromLocal: Matrix4,
    height: number,
  ): boolean {
    if (this.mode !== 'auto') return (this.on = images.length > 0 && this.mode === 'surface');
    const { clipFromPixel } = this;
    const zoom = Math.cbrt(Math.abs(sceneFromLocal.determinant()));
    const scale = 0.5 * height * camera.projectionMatrix.elements[5] * zoom;
    const most = this.on ? NO_GAPS : GAPS;
    this.on = false;
    for (let i = 0; i < images.length && !this.on; i++) {
      const image = images[i]!;
      clipFromPixel.multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
      clipFromPixel.multiply(sceneFromLocal).multiply(this.raysOf(image));
      this.on = this.hasGaps(image, (stepsOf(image.lattice).x * scale) / most);
    }
    return this.on;
  }

  private raysOf(image: DepthImage): Matrix4 {
    let rays = this.rays.get(image);
    if (!rays) this.rays.set(image, (rays = raysMatrix(image)));
    return rays;
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
