/** Large frames: requests the most useful chunks and drops others, within a budget of points. */
import { Box3, Frustum, Matrix4, Vector3, WebGLCoordinateSystem } from 'three';
import { ALL_POINTS, type CloudFrame } from '../cloud/points/frame';
import type { Viewer } from '../cloud/picture/viewer';
import type { Link } from '../net/link';
import { apiUrl } from '../net/rest';
import type { Chunk, ChunkTable } from '../protocol/values';
import { state } from '../store/state';
import type { Playback } from './playback';

/** Points kept at once. */
const BUDGET = 3_000_000;
const BUDGET_SOFTWARE = 700_000;
/** Factor of the budget up to which chunks out of view are kept. */
const SLACK = 1.25;
const PERIOD_MS = 250;
const RETRY_MS = 2000;
/** Chunks that have not arrived after this time are requested again: the link may be lost. */
const PATIENCE_MS = 2000;
/** Most chunks of one wish. */
const LONGEST = 4096;

export class Detail {
  private nodes: OctreeNode[] = [];
  private parents: number[] = [];
  private order = '';
  private key = '';
  private next = 0;
  /** Last requested chunks, the time of the request, and the state of the frame then. */
  private asked = new Set<number>();
  private requestedAt = 0;
  private version = -1;
  private readonly matrix = new Matrix4();
  private readonly view: View & { pixels: number } = {
    eye: new Vector3(),
    frustum: new Frustum(),
    pixels: 1,
  };

  constructor(
    private readonly viewer: Viewer,
    private readonly playback: Playback,
    private readonly link: Link,
  ) {}

  /** Points that may be here at once, when `limit` can be drawn in time. */
  budget(limit = ALL_POINTS): number {
    return Math.min(limit, this.viewer.software ? BUDGET_SOFTWARE : BUDGET);
  }

  /** Before each picture; `limit`: points that may be drawn. */
  update(now: number, limit: number): void {
    const info = state.sequence.peek();
    if (!info?.large || now < this.next) return;
    this.next = now + PERIOD_MS;
    const frame = state.frame.peek();
    const key = `${info.identity}/${frame}`;
    if (key !== this.key) {
      this.key = key;
      this.nodes = [];
      this.asked.clear();
      void this.load(info.id, frame, key);
    }
    const cloud = this.playback.store.get(frame);
    if (this.nodes.length > 0 && cloud) this.choose(cloud, this.budget(limit), now);
  }

  private async load(id: string, frame: number, key: string): Promise<void> {
    const url = apiUrl(`sequences/${encodeURIComponent(id)}/frames/${frame}/chunks`);
    const response = await fetch(url, { credentials: 'same-origin' }).catch(() => null);
    if (key !== this.key) return;
    if (!response?.ok) {
      this.key = '';
      this.next = performance.now() + RETRY_MS;
      return;
    }
    const { chunks } = (await response.json()) as ChunkTable;
    this.nodes = chunks.map(nodeOf);
    this.parents = this.nodes.map((node) => node.parent);
    this.order = '';
  }

  private choose(cloud: CloudFrame, budget: number, now: number): void {
    this.look();
    const chosen = worthwhile(this.nodes, this.view, budget).map((node) => node.index);
    const order = chosen.join();
    if (order !== this.order) this.viewer.setOrder(chosen, this.parents);
    this.order = order;
    const loaded = new Set(cloud.pieces.map((piece) => piece.index));
    const missing = chosen.filter((index) => !loaded.has(index)).slice(0, LONGEST);
    this.drop(cloud, new Set(chosen), missing, SLACK * budget);
    this.ask(cloud, new Set(chosen), loaded, missing, now);
  }

  /** Compute the camera's position in the frame's coordinates, at the desk or in the headset. */
  private look(): void {
    const { camera, room, viewHeight, renderer } = this.viewer;
    // In the headset the camera has the eyes' projection.
    const reversed = renderer.xr.isPresenting && this.viewer.reversible;
    const { view, matrix } = this;
    camera.updateMatrixWorld();
    matrix.multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    view.frustum.setFromProjectionMatrix(
      matrix.multiply(room.matrixWorld),
      WebGLCoordinateSystem,
      reversed,
    );
    view.eye.setFromMatrixPosition(camera.matrixWorld);
    view.eye.applyMatrix4(matrix.copy(room.matrixWorld).invert());
    view.pixels = Math.max(1, viewHeight / 2) * camera.projectionMatrix.elements[5];
    // The eye of an orthographic picture has about the same distance from all points.
    if (camera.orthographic && !renderer.xr.isPresenting) {
      view.pixels *= camera.position.distanceTo(this.viewer.middle);
    }
  }

  /** Make room by dropping the least useful chunks, the finest first. */
  private drop(cloud: CloudFrame, keep: Set<number>, missing: number[], most: number): void {
    let points = cloud.loaded;
    for (const index of missing) points += this.nodes[index]!.count;
    if (points <= most) return;
    const idle = cloud.pieces.filter((piece) => !keep.has(piece.index));
    idle.sort((a, b) => b.level - a.level);
    const dropped: number[] = [];
    for (const piece of idle) {
      if (points <= most) break;
      points -= piece.count;
      dropped.push(piece.index);
    }
    if (dropped.length > 0) this.playback.dropChunks(cloud, dropped);
  }

  private ask(
    cloud: CloudFrame,
    keep: Set<number>,
    loaded: Set<number>,
    missing: number[],
    now: number,
  ): void {
    if (cloud.pointsVersion !== this.version) this.requestedAt = now;
    this.version = cloud.pointsVersion;
    const fresh = missing.some((index) => !this.asked.has(index));
    const withdrawn = [...this.asked].some((index) => !keep.has(index) && !loaded.has(index));
    const overdue = missing.length > 0 && now - this.requestedAt > PATIENCE_MS;
    if (!fresh && !withdrawn && !overdue) return;
    this.asked = new Set(missing);
    this.requestedAt = now;
    this.link.send({ type: 'want', frame: cloud.index, chunks: missing });
  }
}

/** Nearer than this nothing gets finer, metres. */
const NEAREST = 0.3;
/** Least distance in pixels of points; a chunk with denser ones adds no visible detail. */
const FINEST_PIXELS = 0.7;
/** Each takes buffers of the GPU, however few its points. */
const MOST_CHUNKS = 256;

/** A chunk of a large frame, as its octree has it. */
export interface OctreeNode {
  readonly index: number;
  readonly count: number;
  readonly box: Box3;
  /** Metres between its points. */
  readonly spacing: number;
  /** −1 at the root. */
  readonly parent: number;
}

/** View of the camera, in the frame's own coordinates. */
export interface View {
  readonly eye: Vector3;
  readonly frustum: Frustum;
  /** Pixels that a metre takes at a distance of one. */
  readonly pixels: number;
}

export function nodeOf({
  index,
  count,
  lo,
  hi,
  parent,
}: Omit<Chunk, 'level' | 'first' | 'offset' | 'nbytes' | 'origin' | 'scale'>): OctreeNode {
  const box = new Box3();
  box.min.fromArray(lo);
  box.max.fromArray(hi);
  const sides = [hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]].sort((a, b) => a - b);
  // Points lie on surfaces: the two longer sides give the area.
  const spacing = Math.sqrt((sides[1]! * sides[2]!) / Math.max(1, count));
  return { index, count, box, spacing, parent };
}

/** Pixels that its parent's points, `spacing` metres apart, leave empty where a chunk lies. */
function gapOf(node: OctreeNode, spacing: number, view: View): number {
  const distance = Math.max(NEAREST, node.box.distanceToPoint(view.eye));
  return (spacing * view.pixels) / distance;
}

const candidates: OctreeNode[] = [];
let gaps = new Float64Array(0);

/**
 * The chunks that matter most, best first, with no more points than `budget`; the first always.
 * A node's place in `nodes` is its number.
 */
export function worthwhile(nodes: readonly OctreeNode[], view: View, budget: number): OctreeNode[] {
  candidates.length = 0;
  if (gaps.length < nodes.length) gaps = new Float64Array(nodes.length);
  for (const node of nodes) {
    const gap = gapOf(node, nodes[node.parent]?.spacing ?? Infinity, view);
    if (gap < FINEST_PIXELS) continue;
    if (node.parent >= 0 && !view.frustum.intersectsBox(node.box)) continue;
    gaps[node.index] = gap;
    candidates.push(node);
  }
  candidates.sort((a, b) => gaps[b.index]! - gaps[a.index]!);
  const chosen: OctreeNode[] = [];
  let points = 0;
  for (const node of candidates) {
    points += node.count;
    if (chosen.length > 0 && (points > budget || chosen.length === MOST_CHUNKS)) break;
    chosen.push(node);
  }
  return chosen;
}
