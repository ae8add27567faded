/** The desk's camera: in perspective, or orthographic, where sizes on screen are sizes in metres. */
import { MathUtils, PerspectiveCamera } from 'three';

export class Lens extends PerspectiveCamera {
  /** Metres from the middle to the upper edge of an orthographic picture; 0: perspective. */
  private half = 0;

  get orthographic(): boolean {
    return this.half > 0;
  }

  get halfHeight(): number {
    return this.half;
  }

  /** 0: perspective. */
  setHalfHeight(metres: number): void {
    this.half = metres;
    this.updateProjectionMatrix();
  }

  /** Metres from the middle to the upper edge of the picture at a distance. */
  halfHeightAt(distance: number): number {
    return this.half || this.halfHeightOf(distance);
  }

  /** The same for a picture in perspective. */
  halfHeightOf(distance: number): number {
    return Math.tan(MathUtils.degToRad(this.fov / 2)) * distance;
  }

  /** The distance at which a picture in perspective shows as much as so many metres do. */
  distanceOf(half: number): number {
    return half / Math.tan(MathUtils.degToRad(this.fov / 2));
  }

  override updateProjectionMatrix(): void {
    super.updateProjectionMatrix();
    // The constructor of three.js calls this before there is a `half`.
    if (!this.half) return;
    const { half, near, far, coordinateSystem, reversedDepth } = this;
    const wide = half * this.aspect;
    const { projectionMatrix } = this;
    projectionMatrix.makeOrthographic(-wide, wide, half, -half, near, far, coordinateSystem, reversedDepth); // prettier-ignore
    this.projectionMatrixInverse.copy(projectionMatrix).invert();
  }
}
