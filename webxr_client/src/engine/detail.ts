/** Large frames: which chunks are worth their points from where one stands. */
import { Frustum, Matrix4, Sphere, Vector3 } from 'three';
import type { Viewer } from '../cloud/viewer';
import type { Link } from '../net/link';
import { apiUrl } from '../net/rest';
import { state } from '../state';
import type { Playback } from './playback';

/** Points kept at once. */
const BUDGET = 3_000_000;
const BUDGET_SOFTWARE = 700_000;
/** A chunk whose points would lie closer than this many pixels adds nothing to see. */
const FINEST_PIXELS = 0.7;
const PERIOD_MS = 250;

interface Node {
  readonly index: number;
  readonly count: number;
  readonly center: Vector3;
  readonly radius: number;
  /** Metres between its points. */
  readonly spacing: number;
  readonly parent: number;
}

interface ChunkRow {
  index: number;
  count: number;
  lo: [number, number, number];
  hi: [number, number, number];
  parent: number;
}

export class Detail {
  private nodes: Node[] = [];
  private key = '';
  private last = 0;
  private wanted = '';
  private readonly frustum = new Frustum();
  private readonly matrix = new Matrix4();
  private readonly eye = new Vector3();
  private readonly sphere = new Sphere();

  constructor(
    private readonly viewer: Viewer,
    private readonly playback: Playback,
    private readonly link: Link,
  ) {}

  update(now: number): void {
    const info = state.sequence.peek();
    if (!info?.large || now - this.last < PERIOD_MS) return;
    this.last = now;
    const frame = state.frame.peek();
    const key = `${info.id}/${frame}`;
    if (key !== this.key) {
      this.key = key;
      this.nodes = [];
      this.wanted = '';
      void this.load(info.id, frame, key);
    }
    if (this.nodes.length > 0) this.choose(frame);
  }

  private async load(id: string, frame: number, key: string): Promise<void> {
    const url = apiUrl(`sequences/${encodeURIComponent(id)}/frames/${frame}/chunks`);
    const response = await fetch(url, { credentials: 'same-origin' });
    if (!response.ok || key !== this.key) return;
    const { chunks } = (await response.json()) as { chunks: ChunkRow[] };
    this.nodes = chunks.map(({ index, count, lo, hi, parent }) => {
      const center = new Vector3(...lo).add(new Vector3(...hi)).multiplyScalar(0.5);
      const size = new Vector3(...hi).sub(new Vector3(...lo));
      const [short, middle, long] = [size.x, size.y, size.z].sort((a, b) => a - b);
      const spacing = Math.sqrt((Math.max(middle!, short!) * long!) / Math.max(1, count));
      return { index, count, center, radius: size.length() / 2, spacing, parent };
    });
    this.viewer.setParents(this.nodes.map((node) => node.parent));
  }

  /** Ask for the chunks that matter most, until the budget is used; drop the others. */
  private choose(frame: number): void {
    const { camera, room } = this.viewer;
    camera.updateMatrixWorld();
    this.matrix.multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    this.matrix.multiply(room.matrixWorld);
    this.frustum.setFromProjectionMatrix(this.matrix);
    this.eye.copy(camera.position).applyMatrix4(this.matrix.copy(room.matrixWorld).invert());
    const chosen = this.worthwhile();
    const keep = new Set(chosen.map((node) => node.index));
    const cloud = this.playback.store.get(frame);
    const here = new Set(cloud?.pieces.map((piece) => piece.index));
    const missing = chosen.filter((node) => !here.has(node.index)).map((node) => node.index);
    if (cloud && cloud.loaded > 1.25 * this.budget) {
      for (const index of here) if (!keep.has(index)) cloud.remove(index);
      this.viewer.show(cloud);
    }
    const list = missing.slice(0, 4096);
    const text = list.join();
    if (text === this.wanted) return;
    this.wanted = text;
    this.link.send({ type: 'want', frame, chunks: list });
  }

  private get budget(): number {
    return this.viewer.software ? BUDGET_SOFTWARE : BUDGET;
  }

  private worthwhile(): Node[] {
    const pixels =
      this.viewer.canvas.height / 2 / Math.tan((this.viewer.camera.fov * Math.PI) / 360);
    const scored: [number, Node][] = [];
    for (const node of this.nodes) {
      const distance = Math.max(0.5, this.eye.distanceTo(node.center) - node.radius);
      // A chunk is worth what its parent's points leave empty on screen.
      const coarse = node.parent < 0 ? Infinity : (this.nodes[node.parent]?.spacing ?? Infinity);
      const gap = (coarse * pixels) / distance;
      if (gap < FINEST_PIXELS) continue;
      this.sphere.center.copy(node.center);
      this.sphere.radius = node.radius;
      if (node.parent >= 0 && !this.frustum.intersectsSphere(this.sphere)) continue;
      scored.push([gap, node]);
    }
    scored.sort((a, b) => b[0] - a[0]);
    const chosen: Node[] = [];
    let points = 0;
    for (const [, node] of scored) {
      points += node.count;
      if (points > this.budget) break;
      chosen.push(node);
    }
    return chosen;
  }
}
