/** One frame on the GPU.  Several slots take turns, so that no upload waits for a draw. */
import type { Matrix4, Object3D } from 'three';
import { ALL_POINTS, pointsWithin, type CloudFrame } from '../../points/frame';
import type { PointUniforms } from '../material';

export abstract class Slot {
  abstract readonly object: Object3D;
  frame: CloudFrame | null = null;
  /** Points that are on the GPU. */
  protected uploaded = 0;
  /** The room with the axes for colours of normals, or null. */
  protected normals: Matrix4 | null = null;
  protected pointsVersion = -1;
  protected labelsVersion = -1;
  /** Labels as last uploaded, in stored order. */
  protected readonly labels: Uint16Array;
  private blank = false;
  private shownPoints = 0;
  private limit = ALL_POINTS;

  constructor(
    protected readonly uniforms: PointUniforms,
    protected readonly capacity: number,
  ) {
    this.labels = new Uint16Array(capacity);
  }

  /** Bring the GPU up to date with a frame; upload only changes. */
  upload(frame: CloudFrame): void {
    const { normals } = this.uniforms;
    if (this.frame !== frame || frame.loaded < this.uploaded || this.normals !== normals) {
      this.frame = frame;
      this.normals = normals;
      this.uploaded = 0;
      this.pointsVersion = -1;
      this.labelsVersion = -1;
    }
    if (this.pointsVersion !== frame.pointsVersion) {
      this.uploadPoints(frame);
      this.cut(frame);
      this.pointsVersion = frame.pointsVersion;
      this.labelsVersion = -1;
    }
    if (this.labelsVersion === frame.labelsVersion) return;
    this.uploadLabels(frame);
    this.labelsVersion = frame.labelsVersion;
  }

  /** Bring over the points beyond `uploaded`. */
  protected abstract uploadPoints(frame: CloudFrame): void;

  private uploadLabels(frame: CloudFrame): void {
    const { labels } = this;
    const plain = frame.blank && frame.predicted === null;
    if (plain && this.blank) return;
    frame.gatherShown(labels, this.uploaded);
    // Blank once is blank for every frame without labels: nothing more goes over.
    if (plain) labels.fill(0);
    this.writeLabels(frame, plain);
    this.blank = plain;
  }

  /** Bring `labels` over: of all points that are there, or of all that there may be. */
  protected abstract writeLabels(frame: CloudFrame, all: boolean): void;

  /** Draw the first points of a frame, which are whole levels. */
  protected abstract show(frame: CloudFrame, points: number): void;

  /** Draw at most about so many points: whole levels, coarse ones first. */
  setLimit(limit: number): void {
    this.limit = limit;
    const { frame } = this;
    // A frame that was dropped no longer describes the points on the GPU.
    if (!frame || frame.loaded < this.uploaded) return;
    if (pointsWithin(frame, limit) !== this.shownPoints) this.cut(frame);
  }

  private cut(frame: CloudFrame): void {
    this.shownPoints = Math.min(this.uploaded, pointsWithin(frame, this.limit));
    this.show(frame, this.shownPoints);
  }

  /** Points with each label as on screen; deleted ones under `DELETED`. */
  countLabels(): Map<number, number> {
    const counts = new Map<number, number>();
    for (let i = 0; i < this.uploaded; i++) {
      const id = this.labels[i]!;
      counts.set(id, (counts.get(id) ?? 0) + 1);
    }
    return counts;
  }

  get drawn(): number {
    return this.shownPoints;
  }

  /** Draw surfaces, or no more. */
  abstract showSurface(on: boolean): void;

  abstract dispose(): void;
}
