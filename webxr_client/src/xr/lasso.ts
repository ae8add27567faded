/** An outline drawn in the air: a volume seen from the head, as a polygon and a camera. */
import { Matrix4, PerspectiveCamera, Vector3 } from 'three';
import type { SequenceInfo } from '../protocol/messages';
import { within } from './vectors';

const STEP = 0.008;
const MOST = 4000;
/** Wide enough for any outline that arms can draw in front of the eyes. */
const FOV = 120;

export class AirLasso {
  /** x, y, z of each corner, in the scene. */
  readonly corners: number[] = [];
  private readonly camera = new PerspectiveCamera(FOV, 1, 0.05, 1000);
  private readonly at = new Vector3();

  begin(): void {
    this.corners.length = 0;
  }

  /** True when a corner was added. */
  add(place: Vector3): boolean {
    const { corners } = this;
    const end = corners.length;
    if (end >= 3) {
      this.at.fromArray(corners, end - 3);
      if (within(this.at, place, STEP) || end >= 3 * MOST) return false;
    }
    corners.push(place.x, place.y, place.z);
    return true;
  }

  /** Polygon and `clip_from_source`, seen from `eye`; null when nothing is enclosed. */
  end(
    eye: Vector3,
    localFromScene: Matrix4,
    info: SequenceInfo,
  ): { polygon: [number, number][]; matrix: number[] } | null {
    const count = this.corners.length / 3;
    if (count < 3) return null;
    const { camera, at } = this;
    const middle = new Vector3();
    for (let i = 0; i < count; i++) middle.add(at.fromArray(this.corners, 3 * i));
    camera.position.copy(eye);
    camera.lookAt(middle.divideScalar(count));
    camera.updateMatrixWorld(true);
    const polygon: [number, number][] = [];
    for (let i = 0; i < count; i++) {
      at.fromArray(this.corners, 3 * i).project(camera);
      polygon.push([clamp(at.x), clamp(at.y)]);
    }
    const [x, y, z] = info.shift;
    const matrix = new Matrix4()
      .multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse)
      .multiply(localFromScene.clone().invert())
      .multiply(new Matrix4().makeTranslation(-x, -y, -z))
      .transpose()
      .toArray();
    return { polygon, matrix };
  }
}

function clamp(value: number): number {
  return Math.min(1, Math.max(-1, value));
}
