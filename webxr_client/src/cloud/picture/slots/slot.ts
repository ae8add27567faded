/** One frame on the GPU.  Several slots take turns, so that no upload waits for a draw. */
import { Group, type Matrix4, type WebGLRenderer } from 'three';
import { ALL_POINTS, pointsWithin, type CloudFrame } from '../../points/frame';
import { LatticePart } from '../lattice/part';
import type { Placement, PointUniforms } from '../material';
import type { Part } from './part';
import { VertexPart } from './vertex-part';

/** Key of the part with the points of all sensors that have no image. */
const POINTS = -1;

export class Slot {
  readonly object = new Group();
  frame: CloudFrame | null = null;
  /** Points that are on the GPU. */
  private uploaded = 0;
  /** The room with the axes for colours of normals, or null. */
  private normals: Matrix4 | null = null;
  private pointsVersion = -1;
  private labelsVersion = -1;
  /** Labels as last uploaded, in stored order. */
  private readonly labels: Uint16Array;
  private blank = false;
  private shownPoints = 0;
  private limit = ALL_POINTS;
  /** By sensor: each depth camera has a grid of its own. */
  private readonly parts = new Map<number, Part>();
  /** The parts that the frame has. */
  private readonly used: Part[] = [];

  /** For frames of at most `capacity` points, in a layer of the camera. */
  constructor(
    private readonly renderer: WebGLRenderer,
    private readonly uniforms: PointUniforms,
    private readonly capacity: number,
    private readonly layer: number,
    private readonly placement: Placement | null = null,
  ) {
    this.labels = new Uint16Array(capacity);
    this.object.matrixAutoUpdate = false;
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
  private uploadPoints(frame: CloudFrame): void {
    const { images, pieces } = frame;
    for (const part of this.used) part.object.visible = false;
    this.used.length = 0;
    for (let i = 0; i < images.length; i++) this.use(images[i]!.sensor, frame);
    if (pieces.some(({ segment }) => segment)) this.use(POINTS, frame);
    for (let i = 0; i < pieces.length; i++) {
      const { first, count } = pieces[i]!;
      if (first + count > this.capacity) break;
      this.uploaded = Math.max(this.uploaded, first + count);
    }
  }

  /** Bring a part up to date; the first frame with a sensor's points makes it. */
  private use(sensor: number, frame: CloudFrame): void {
    let part = this.parts.get(sensor);
    if (!part) {
      const { renderer, uniforms, placement } = this;
      const image = frame.imageOf(sensor);
      part = image
        ? new LatticePart(renderer, image, uniforms, placement)
        : new VertexPart(renderer, this.capacity, uniforms, placement);
      part.object.traverse((object) => object.layers.set(this.layer));
      this.object.add(part.object);
      this.parts.set(sensor, part);
      this.blank = false;
    }
    part.object.visible = true;
    this.used.push(part);
    part.uploadPoints(frame, this.uploaded, this.normals);
  }

  private uploadLabels(frame: CloudFrame): void {
    const { labels } = this;
    const plain = frame.blank && frame.predicted === null;
    if (plain && this.blank) return;
    frame.gatherShown(labels, this.uploaded);
    // Blank once is blank for every frame without labels: nothing more goes over.
    if (plain) labels.fill(0);
    const parts = plain ? this.parts.values() : this.used;
    for (const part of parts) part.writeLabels(frame, labels, this.uploaded, plain);
    this.blank = plain;
  }

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
    for (const part of this.used) part.show(frame, this.shownPoints);
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
  showSurface(on: boolean): void {
    for (const part of this.parts.values()) part.showSurface(on);
  }

  dispose(): void {
    this.object.removeFromParent();
    for (const part of this.parts.values()) part.dispose();
  }
}
