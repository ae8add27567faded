/** Preallocated GPU buffers for one frame.  Several take turns, so that no upload waits for a draw. */
import { free } from '../../common/free';
import { Points } from 'three';
import type { BufferGeometry, Matrix4, RawShaderMaterial, WebGLRenderer } from 'three';
import { ALL_POINTS, pointsWithin, type CloudFrame } from '../points/frame';
import { DELETED } from '../points/piece';
import { PointBuffers } from './gpu';
import { ChunkTable, pointMaterial, type Placement, type PointUniforms } from './material';

export class Slot {
  readonly points: Points<BufferGeometry, RawShaderMaterial>;
  frame: CloudFrame | null = null;
  /** Labels as last uploaded. */
  private readonly shown: Uint16Array;
  private pointsVersion = -1;
  private labelsVersion = -1;
  private uploaded = 0;
  private shownPoints = 0;
  private limit = ALL_POINTS;
  private blank = false;
  private normals: Matrix4 | null = null;
  private readonly buffers: PointBuffers;
  private readonly table: ChunkTable;

  constructor(
    renderer: WebGLRenderer,
    readonly capacity: number,
    private readonly uniforms: PointUniforms,
    placement: Placement | null = null,
  ) {
    this.buffers = new PointBuffers(renderer.getContext() as WebGL2RenderingContext, capacity);
    this.table = new ChunkTable(renderer);
    this.shown = new Uint16Array(capacity);
    this.points = new Points(
      this.buffers.geometry(),
      pointMaterial(uniforms, this.table, -1, placement),
    );
    this.points.frustumCulled = false;
    this.points.visible = false;
    this.points.matrixAutoUpdate = false;
  }

  /** Whether the GPU has this frame as it is now. */
  holds(frame: CloudFrame): boolean {
    return this.frame === frame && this.pointsVersion === frame.pointsVersion;
  }

  /** Bring the GPU up to date with a frame: only what is new goes over. */
  upload(frame: CloudFrame): void {
    const { normals } = this.uniforms;
    if (this.frame !== frame || frame.loaded < this.uploaded || this.normals !== normals) {
      this.frame = frame;
      this.normals = normals;
      this.uploaded = 0;
      this.pointsVersion = -1;
      this.labelsVersion = -1;
    }
    if (this.pointsVersion !== frame.pointsVersion) this.uploadPoints(frame);
    if (this.labelsVersion !== frame.labelsVersion) this.uploadLabels(frame);
  }

  private uploadPoints(frame: CloudFrame): void {
    const { pieces } = frame;
    for (let i = 0; i < pieces.length; i++) {
      const piece = pieces[i]!;
      const { first, segment } = piece;
      if (first < this.uploaded) continue;
      // Points of one message lie together, and go over in one piece.
      let { count } = piece;
      const begin = i;
      while (pieces[i + 1]?.segment === segment) count += pieces[++i]!.count;
      if (first + count > this.capacity) break;
      const { normals } = this;
      if (normals) this.buffers.writeNormals(first, pieces.slice(begin, i + 1), normals);
      else this.buffers.writeVertices(first, piece, count);
      this.uploaded = first + count;
    }
    this.cut(frame);
    this.pointsVersion = frame.pointsVersion;
    this.labelsVersion = -1;
  }

  /** Draw at most about so many points: whole levels, coarse ones first. */
  setLimit(limit: number): void {
    this.limit = limit;
    const { frame } = this;
    // A frame that was dropped meanwhile says nothing any more of what is on the GPU.
    if (!frame || frame.loaded < this.uploaded) return;
    if (pointsWithin(frame, limit) !== this.shownPoints) this.cut(frame);
  }

  private cut(frame: CloudFrame): void {
    this.shownPoints = Math.min(this.uploaded, pointsWithin(frame, this.limit));
    this.table.set(frame, this.shownPoints);
    this.points.geometry.setDrawRange(0, this.shownPoints);
  }

  private uploadLabels(frame: CloudFrame): void {
    const { shown } = this;
    this.labelsVersion = frame.labelsVersion;
    const plain = frame.blank && frame.predicted === null;
    if (plain && this.blank) return;
    frame.gatherShown(shown, this.uploaded);
    // Blank once is blank for every frame without labels: nothing more goes over.
    if (plain) shown.fill(0);
    this.buffers.writeLabels(shown, plain ? this.capacity : this.uploaded);
    this.blank = plain;
  }

  /** Points with each label as on screen; deleted ones under `DELETED`. */
  countLabels(): Map<number, number> {
    const counts = new Map<number, number>();
    for (let i = 0; i < this.uploaded; i++) {
      const id = this.shown[i] ?? DELETED;
      counts.set(id, (counts.get(id) ?? 0) + 1);
    }
    return counts;
  }

  get drawn(): number {
    return this.shownPoints;
  }

  dispose(): void {
    free(this.points);
    this.table.dispose();
    this.buffers.dispose();
  }
}
