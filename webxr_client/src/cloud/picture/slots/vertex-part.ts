/** The points of a frame that came as points: vertices in preallocated buffers. */
import { free } from '../../../common/free';
import { Points } from 'three';
import type { BufferGeometry, Matrix4, RawShaderMaterial, WebGLRenderer } from 'three';
import type { CloudFrame } from '../../points/frame';
import { PointBuffers } from '../gpu';
import { ChunkTable, pointMaterial, type Placement, type PointUniforms } from '../material';
import type { Part } from './part';

export class VertexPart implements Part {
  readonly object: Points<BufferGeometry, RawShaderMaterial>;
  private readonly buffers: PointBuffers;
  private readonly table: ChunkTable;
  /** Labels without those of depth images, whose points lie between. */
  private own: Uint16Array | null = null;

  constructor(
    renderer: WebGLRenderer,
    capacity: number,
    uniforms: PointUniforms,
    placement: Placement | null,
  ) {
    this.buffers = new PointBuffers(renderer.getContext() as WebGL2RenderingContext, capacity);
    this.table = new ChunkTable(renderer);
    const material = pointMaterial(uniforms, this.table, -1, placement);
    this.object = new Points(this.buffers.geometry(), material);
    this.object.frustumCulled = false;
    this.object.matrixAutoUpdate = false;
  }

  uploadPoints({ pieces }: CloudFrame, from: number, normals: Matrix4 | null): void {
    let place = 0;
    for (let i = 0; i < pieces.length; i++) {
      const piece = pieces[i]!;
      const { first, segment } = piece;
      if (!segment) continue;
      // Points of one message lie together, and go over in one piece.
      let { count } = piece;
      const begin = i;
      while (pieces[i + 1]?.segment === segment) count += pieces[++i]!.count;
      if (place + count > this.buffers.capacity) break;
      if (first >= from) {
        if (normals) this.buffers.writeNormals(place, pieces.slice(begin, i + 1), normals);
        else this.buffers.writeVertices(place, piece, count);
      }
      place += count;
    }
  }

  show(frame: CloudFrame, points: number): void {
    this.table.set(frame, points);
    let drawn = 0;
    const { pieces } = frame;
    for (let i = 0; i < pieces.length && pieces[i]!.first < points; i++) {
      if (pieces[i]!.segment) drawn += pieces[i]!.count;
    }
    this.object.geometry.setDrawRange(0, drawn);
  }

  writeLabels(frame: CloudFrame, labels: Uint16Array, count: number, all: boolean): void {
    if (frame.images.length === 0 || all) {
      this.buffers.writeLabels(labels, all ? this.buffers.capacity : count);
      return;
    }
    const own = (this.own ??= new Uint16Array(this.buffers.capacity));
    let place = 0;
    for (const { first, count: points, segment } of frame.pieces) {
      if (!segment || first + points > count) continue;
      own.set(labels.subarray(first, first + points), place);
      place += points;
    }
    this.buffers.writeLabels(own, place);
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
