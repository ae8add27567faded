/** The GPU's part of a frame: of one sensor, or of all sensors without an image. */
import type { Matrix4, Object3D } from 'three';
import type { CloudFrame } from '../../points/frame';

export interface Part {
  readonly object: Object3D;
  /** Bring over the points from stored number `from` on, in their colours or those of normals. */
  uploadPoints(frame: CloudFrame, from: number, normals: Matrix4 | null): void;
  /** Draw what it has of a frame's first points, which are whole levels. */
  show(frame: CloudFrame, points: number): void;
  /** Bring over labels in stored order; `all`: those of all points that there may be. */
  writeLabels(frame: CloudFrame, labels: Uint16Array, count: number, all: boolean): void;
  /** Draw surfaces, or no more. */
  showSurface(on: boolean): void;
  dispose(): void;
}
