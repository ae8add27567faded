/** The clip box at work: its first size, its drawing, and the object that it follows. */
import { Vector3 } from 'three';
import { clip, clipMatrix, centerClip, type Clip } from '../tools/clip';
import type { CloudFrame } from '../cloud/points/frame';
import type { Viewer } from '../cloud/picture/viewer';
import { placeOfLabel } from '../cloud/points/whereabouts';
import type { DeskCamera } from './camera';
import { state } from '../store/state';
import { follow, watch } from '../store/watch';
import type { Volume } from '../tools/volume';

/** A box begins so many times as wide as the object's radius. */
const ROUND_OBJECT = 3;
/** Size of a box around the target, and thickness of a slab, as parts of the picture's height there. */
const [ROUND_VIEW, SLAB] = [0.5, 0.08];

export interface ClippingDeps {
  readonly viewer: Viewer;
  readonly camera: DeskCamera;
  /** The frame on screen. */
  readonly frame: () => CloudFrame | null;
}

export class Clipping {
  private seen: CloudFrame | null = null;
  private version = -1;

  constructor(private readonly deps: ClippingDeps) {
    const { viewer } = deps;
    follow(() => {
      viewer.uniforms.setClip(clipMatrix.value);
      viewer.invalidate();
    });
    let opened = state.sequence.peek()?.id;
    watch([state.sequence], () => {
      const id = state.sequence.peek()?.id;
      if (id !== opened) clip.value = null;
      opened = id;
    });
  }

  /** Clip to a box around the active object or the camera's target, or to a slab across an axis. */
  set(slab: Clip['slab']): void {
    const follows = clip.peek()?.follows ?? false;
    clip.value = { volume: slab === null ? this.box() : this.slab(slab), slab, follows };
  }

  private get object(): { middle: Vector3; radius: number } | null {
    const frame = this.deps.frame();
    const place = frame && placeOfLabel(frame, state.activeLabel.peek());
    return place && { ...place, middle: place.middle.applyMatrix4(this.deps.viewer.room.matrix) };
  }

  /** Metres from the lower to the upper edge of the picture where one looks. */
  private get pictureHeight(): number {
    const { camera } = this.deps.viewer;
    return 2 * camera.halfHeightAt(camera.position.distanceTo(this.deps.camera.pivot));
  }

  private box(): Volume {
    const { object } = this;
    const middle = object?.middle ?? this.deps.camera.pivot;
    const edge = object ? ROUND_OBJECT * object.radius : ROUND_VIEW * this.pictureHeight;
    return { center: middle.toArray(), size: [edge, edge, edge], yaw: 0 };
  }

  /** Return a slab across an axis of the current view. */
  private slab(axis: 0 | 1 | 2): Volume {
    const { camera, viewer } = this.deps;
    const info = state.sequence.peek();
    const middle = this.object?.middle ?? camera.pivot;
    const right = new Vector3().setFromMatrixColumn(viewer.camera.matrixWorld, 0);
    const [low, high] = info ? viewer.bounds(info) : [middle, middle];
    const wide = high.clone().sub(low);
    const longest = Math.hypot(wide.x, wide.z);
    const size: [number, number, number] = [longest, wide.y, longest];
    size[axis] = SLAB * this.pictureHeight;
    return { center: middle.toArray(), size, yaw: Math.atan2(-right.z, right.x) };
  }

  /** Before each picture. */
  update(): void {
    const frame = this.deps.frame();
    const follows = clip.peek()?.follows === true;
    if (!frame || !follows) {
      this.seen = null;
      return;
    }
    // Its own points as they grow do not pull the box along while one paints.
    if (frame === this.seen && (frame.loaded === this.version || !frame.complete)) return;
    const { object } = this;
    if (frame.complete) this.seen = frame;
    this.version = frame.loaded;
    if (object) centerClip(object.middle);
  }
}
