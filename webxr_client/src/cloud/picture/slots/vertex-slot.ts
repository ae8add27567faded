/** A frame with points as vertices, in preallocated buffers. */
import { free } from '../../../common/free';
import { Points } from 'three';
import type { BufferGeometry, RawShaderMaterial, WebGLRenderer } from 'three';
import type { CloudFrame } from '../../points/frame';
import { PointBuffers } from '../gpu';
import { ChunkTable, pointMaterial, type Placement, type PointUniforms } from '../material';
import { Slot } from './slot';

export class VertexSlot extends Slot {
  readonly object: Points<BufferGeometry, RawShaderMaterial>;
  private readonly buffers: PointBuffers;
  private readonly table: ChunkTable;

  constructor(
    renderer: WebGLRenderer,
    capacity: number,
    uniforms: PointUniforms,
    placement: Placement | null,
  ) {
    super(uniforms, capacity);
    this.buffers = new PointBuffers(renderer.getContext() as WebGL2RenderingContext, capacity);
    this.table = new ChunkTable(renderer);
    const material = pointMaterial(uniforms, this.table, -1, placement);
    this.object = new Points(this.buffers.geometry(), material);
    this.object.frustumCulled = false;
    this.object.matrixAutoUpdate = false;
  }

  protected uploadPoints(frame: CloudFrame): void {
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
  }

  protected show(frame: CloudFrame, points: number): void {
    this.table.set(frame, points);
    this.object.geometry.setDrawRange(0, points);
  }

  protected writeLabels(_: CloudFrame, all: boolean): void {
    this.buffers.writeLabels(this.labels, all ? this.capacity : this.uploaded);
  }

  showSurface(): void {
    // Points without neighbours make none.
  }

  dispose(): void {
    free(this.object);
    this.table.dispose();
    this.buffers.dispose();
  }
}
