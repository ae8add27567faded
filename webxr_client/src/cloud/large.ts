/** A frame too large for memory: its chunks live in pages of the GPU, under a budget of points. */
import { Group, Points, Vector3 } from 'three';
import type { BufferGeometry, RawShaderMaterial } from 'three';
import { lowerBound, type CloudFrame, type Piece } from './frame';
import { PointBuffers } from './gpu';
import { ChunkTable, pointMaterial, type PointUniforms } from './material';

export const PAGE_POINTS = 65536;
/** Somewhat more than the half that each level brings: not all below a chunk is refined. */
const REFINED = 0.6;

class Page {
  readonly points: Points<BufferGeometry, RawShaderMaterial>;
  piece: Piece | null = null;
  labelsVersion = -1;
  private readonly buffers: PointBuffers;

  constructor(
    gl: WebGL2RenderingContext,
    uniforms: PointUniforms,
    private readonly table: ChunkTable,
    private readonly row: number,
  ) {
    this.buffers = new PointBuffers(gl, PAGE_POINTS);
    this.points = new Points(this.buffers.geometry(), pointMaterial(uniforms, table, row));
    this.points.visible = false;
    this.points.matrixAutoUpdate = false;
  }

  load(piece: Piece): void {
    this.buffers.writeVertices(0, piece.bytes);
    const sphere = this.points.geometry.boundingSphere!;
    sphere.center.fromArray(piece.lo).add(corner.fromArray(piece.hi)).multiplyScalar(0.5);
    sphere.radius = sphere.center.distanceTo(corner);
    this.points.geometry.setDrawRange(0, piece.count);
    this.points.visible = true;
    this.piece = piece;
    this.labelsVersion = -1;
  }

  loadLabels(frame: CloudFrame): void {
    const { piece } = this;
    if (!piece || this.labelsVersion === frame.labelsVersion) return;
    this.labelsVersion = frame.labelsVersion;
    if (piece.labels) scratch.set(piece.labels);
    else scratch.fill(0, 0, piece.count);
    for (const { indices, values } of frame.overlays.values()) {
      const single = values.length === 1;
      const stop = lowerBound(indices, piece.first + piece.count);
      for (let i = lowerBound(indices, piece.first); i < stop; i++) {
        scratch[indices[i]! - piece.first] = values[single ? 0 : i]!;
      }
    }
    this.buffers.writeLabels(scratch, piece.count);
  }

  /** Where finer chunks cover the same place, coarse points shrink to their size. */
  setDensity(factor: number): void {
    const { piece } = this;
    if (piece) this.table.setRow(this.row, piece.origin, piece.scale, factor);
  }

  clear(): void {
    this.piece = null;
    this.points.visible = false;
  }

  dispose(): void {
    this.points.removeFromParent();
    this.points.material.dispose();
    this.points.geometry.dispose();
    this.buffers.dispose();
  }
}

const corner = new Vector3();
const scratch = new Uint16Array(PAGE_POINTS);

export class LargeCloud {
  readonly group = new Group();
  private readonly pages: Page[] = [];
  private readonly table = new ChunkTable();
  /** Chunk → the chunk above it in the octree, −1 at the root. */
  private parents: ArrayLike<number> = [];

  constructor(
    private readonly gl: WebGL2RenderingContext,
    private readonly uniforms: PointUniforms,
  ) {
    this.group.matrixAutoUpdate = false;
  }

  setParents(parents: ArrayLike<number>): void {
    this.parents = parents;
  }

  /** Make the pages hold exactly the frame's chunks. */
  update(frame: CloudFrame): void {
    const here = new Set(frame.pieces);
    for (const page of this.pages) if (page.piece && !here.has(page.piece)) page.clear();
    const shown = new Set(this.pages.map((page) => page.piece));
    for (const piece of frame.pieces) {
      if (!shown.has(piece)) this.freePage().load(piece);
    }
    this.setDensities(frame);
    for (const page of this.pages) page.loadLabels(frame);
  }

  /** A coarse chunk's points become as small as those of the finest chunks below it. */
  private setDensities(frame: CloudFrame): void {
    const depths = new Map<number, number>();
    const indices = frame.pieces.map((piece) => piece.index).sort((one, other) => other - one);
    // A chunk's number is above its parent's: from the last to the first, children come first.
    for (const index of indices) {
      const parent = this.parents[index] ?? -1;
      const depth = (depths.get(index) ?? 0) + 1;
      depths.set(parent, Math.max(depths.get(parent) ?? 0, depth));
    }
    for (const page of this.pages) {
      if (page.piece) page.setDensity(0.9 * REFINED ** (depths.get(page.piece.index) ?? 0));
    }
  }

  private freePage(): Page {
    const free = this.pages.find((page) => !page.piece);
    if (free) return free;
    const page = new Page(this.gl, this.uniforms, this.table, this.pages.length);
    page.points.layers.mask = this.group.layers.mask;
    this.pages.push(page);
    this.group.add(page.points);
    return page;
  }

  get drawn(): number {
    return this.pages.reduce((sum, page) => sum + (page.piece?.count ?? 0), 0);
  }

  dispose(): void {
    for (const page of this.pages) page.dispose();
    this.table.texture.dispose();
    this.group.removeFromParent();
  }
}
