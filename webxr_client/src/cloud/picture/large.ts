/** A frame too large for memory: its chunks live in pages of the GPU, under a budget of points. */
import { free } from '../../common/free';
import { Group, Points, Vector3 } from 'three';
import type { BufferGeometry, Matrix4, RawShaderMaterial, WebGLRenderer } from 'three';
import { ALL_POINTS, type CloudFrame, type Predicted } from '../points/frame';
import { lowerBound, type Piece } from '../points/piece';
import { PointBuffers } from './gpu';
import { ChunkTable, pointMaterial, type PointUniforms } from './material';

export const PAGE_POINTS = 65536;
/** Somewhat more than the half that each level brings: not all below a chunk is refined. */
const REFINED = 0.6;

class Page {
  readonly points: Points<BufferGeometry, RawShaderMaterial>;
  piece: Piece | null = null;
  normals: Matrix4 | null = null;
  private labelsVersion = -1;
  /** Values are shown over the server's own. */
  private overlaid = false;
  private predicted: Predicted | null = null;
  private readonly buffers: PointBuffers;

  constructor(
    gl: WebGL2RenderingContext,
    private readonly uniforms: PointUniforms,
    private readonly table: ChunkTable,
    private readonly row: number,
  ) {
    this.buffers = new PointBuffers(gl, PAGE_POINTS);
    this.points = new Points(this.buffers.geometry(), pointMaterial(uniforms, table, row));
    this.points.visible = false;
    this.points.matrixAutoUpdate = false;
  }

  load(piece: Piece): void {
    this.normals = this.uniforms.normals;
    if (this.normals) this.buffers.writeNormals(0, [piece], this.normals);
    else this.buffers.writeVertices(0, piece, piece.count);
    const sphere = this.points.geometry.boundingSphere!;
    sphere.center.fromArray(piece.lo).add(corner.fromArray(piece.hi)).multiplyScalar(0.5);
    sphere.radius = sphere.center.distanceTo(corner);
    this.points.geometry.setDrawRange(0, piece.count);
    this.piece = piece;
    this.labelsVersion = -1;
  }

  /** Bring the labels over, if an edit, an overlay or a prediction met this chunk. */
  loadLabels(frame: CloudFrame): void {
    const { piece } = this;
    if (!piece) return;
    const { first, count } = piece;
    let overlaid = false;
    for (const { indices } of frame.overlays.values()) {
      const at = indices[lowerBound(indices, first)];
      overlaid ||= at !== undefined && at < first + count;
    }
    const same = this.labelsVersion === piece.labelsVersion && this.predicted === frame.predicted;
    if (same && !overlaid && !this.overlaid) return;
    this.labelsVersion = piece.labelsVersion;
    this.predicted = frame.predicted;
    this.overlaid = overlaid;
    gather(frame, piece);
    this.buffers.writeLabels(scratch, count);
  }

  /** Shrink coarse points to the size of finer chunks that cover the same place. */
  setDensity(factor: number): void {
    const { piece } = this;
    if (piece) this.table.setRow(this.row, piece, factor);
  }

  clear(): void {
    this.piece = null;
    this.points.visible = false;
  }

  dispose(): void {
    free(this.points);
    this.buffers.dispose();
  }
}

const corner = new Vector3();
const scratch = new Uint16Array(PAGE_POINTS);

/** Write the values of a chunk, as shown, to `scratch`. */
function gather(frame: CloudFrame, { labels, first, count }: Piece): void {
  if (labels) scratch.set(labels);
  else scratch.fill(0, 0, count);
  for (const { indices, values } of frame.overlays.values()) {
    const single = values.length === 1;
    const stop = lowerBound(indices, first + count);
    for (let i = lowerBound(indices, first); i < stop; i++) {
      scratch[indices[i]! - first] = values[single ? 0 : i]!;
    }
  }
  frame.fillPredicted(scratch, first, count);
}

export class LargeCloud {
  readonly group = new Group();
  /** Points that are drawn. */
  drawn = 0;
  private readonly pages: Page[] = [];
  private readonly table: ChunkTable;
  /** Chunk → the chunk above it in the octree, −1 at the root. */
  private parents: readonly number[] = [];
  /** Chunk → how many are worth more from where one stands. */
  private ranks = new Map<number, number>();
  private limit = ALL_POINTS;

  constructor(
    private readonly renderer: WebGLRenderer,
    private readonly uniforms: PointUniforms,
  ) {
    this.table = new ChunkTable(renderer);
    this.group.matrixAutoUpdate = false;
  }

  /** See `Viewer.setOrder`. */
  setOrder(order: readonly number[], parents: readonly number[]): void {
    this.parents = parents;
    this.ranks = new Map(order.map((index, rank) => [index, rank]));
    this.select();
  }

  /** Draw at most about so many points. */
  setLimit(limit: number): void {
    this.limit = limit;
    this.select();
  }

  /** Make the pages hold exactly the frame's chunks. */
  update(frame: CloudFrame): void {
    const pieces = new Set(frame.pieces);
    const { normals } = this.uniforms;
    for (const page of this.pages) {
      if (page.piece && (!pieces.has(page.piece) || page.normals !== normals)) page.clear();
    }
    const shown = new Set(this.pages.map((page) => page.piece));
    for (const piece of frame.pieces) {
      if (!shown.has(piece)) this.freePage().load(piece);
    }
    for (const page of this.pages) page.loadLabels(frame);
    this.select();
  }

  /** Show as many loaded chunks as the limit allows. */
  private select(): void {
    const rank = (page: Page): number => this.ranks.get(page.piece!.index) ?? Infinity;
    const held = this.pages.filter((page) => page.piece);
    if (this.limit < ALL_POINTS) held.sort((a, b) => rank(a) - rank(b));
    let points = 0;
    for (const page of held) {
      const { count } = page.piece!;
      // The chunk that covers everything is always there.
      page.points.visible = points === 0 || points + count <= this.limit;
      if (page.points.visible) points += count;
    }
    this.drawn = points;
    this.setDensities(held.filter((page) => page.points.visible));
  }

  /** Make a coarse chunk's points as small as the points of the finest chunks below it. */
  private setDensities(shown: readonly Page[]): void {
    const depths = new Map<number, number>();
    const indices = shown.map((page) => page.piece!.index).sort((one, other) => other - one);
    // A chunk's number is above its parent's: from the last to the first, children come first.
    for (const index of indices) {
      const parent = this.parents[index] ?? -1;
      const depth = (depths.get(index) ?? 0) + 1;
      depths.set(parent, Math.max(depths.get(parent) ?? 0, depth));
    }
    for (const page of shown) {
      page.setDensity(0.9 * REFINED ** (depths.get(page.piece!.index) ?? 0));
    }
    this.table.upload();
  }

  private freePage(): Page {
    const free = this.pages.find((page) => !page.piece);
    if (free) return free;
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    const page = new Page(gl, this.uniforms, this.table, this.pages.length);
    page.points.layers.mask = this.group.layers.mask;
    this.pages.push(page);
    this.group.add(page.points);
    return page;
  }

  dispose(): void {
    for (const page of this.pages) page.dispose();
    this.table.dispose();
    this.group.removeFromParent();
  }
}
