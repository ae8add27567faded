/** From the scene to the recording: `local` is where its points are stored, metres. */
import { Matrix4, Vector3 } from 'three';
import type { Viewer } from '../../cloud/picture/viewer';
import { turnBy } from '../drawing/vectors';

export class Place {
  readonly localFromScene = new Matrix4();
  /** Metres of the scene for one of the recording. */
  scale = 1;

  constructor(private readonly viewer: Viewer) {}

  /** Once per frame, after the world may have moved. */
  update(): void {
    const { world, room } = this.viewer;
    world.updateMatrixWorld(true);
    this.localFromScene.copy(room.matrixWorld).invert();
    this.scale = world.scale.x;
  }

  /** `scene` and `local` may be the same vector. */
  toLocal(scene: Vector3, local: Vector3): Vector3 {
    return local.copy(scene).applyMatrix4(this.localFromScene);
  }

  directionToLocal(scene: Vector3, local: Vector3): Vector3 {
    return turnBy(this.localFromScene, scene, local);
  }
}
