/** The octree of a large frame: which chunks are worth their points from where one stands. */
import { Box3, type Frustum, type Vector3 } from 'three';

/** Nearer than this nothing gets finer, metres. */
const NEAREST = 0.3;
/** A chunk whose points would lie closer than this many pixels adds nothing to see. */
const FINEST_PIXELS = 0.7;
/** Each takes buffers of the GPU, however few its points. */
const MOST_CHUNKS = 256;

export interface OctreeNode {
  readonly index: number;
  readonly count: number;
  readonly box: Box3;
  /** Metres between its points. */
  readonly spacing: number;
  /** −1 at the root. */
  readonly parent: number;
}

/** A row of the server's table of chunks. */
export interface ChunkRow {
  readonly index: number;
  readonly count: number;
  readonly lo: readonly [number, number, number];
  readonly hi: readonly [number, number, number];
  readonly parent: number;
}

/** View of the camera, in the frame's own coordinates. */
export interface View {
  readonly eye: Vector3;
  readonly frustum: Frustum;
  /** Pixels that a metre takes at a distance of one. */
  readonly pixels: number;
}

export function nodeOf({ index, count, lo, hi, parent }: ChunkRow): OctreeNode {
  const box = new Box3();
  box.min.fromArray(lo);
  box.max.fromArray(hi);
  const sides = [hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]].sort((a, b) => a - b);
  // Points lie on surfaces: the two longer sides tell how large theirs is.
  const spacing = Math.sqrt((sides[1]! * sides[2]!) / Math.max(1, count));
  return { index, count, box, spacing, parent };
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
    // A chunk is worth what its parent's points leave empty on screen.
    const coarse = node.parent < 0 ? Infinity : (nodes[node.parent]?.spacing ?? Infinity);
    const distance = Math.max(NEAREST, node.box.distanceToPoint(view.eye));
    const gap = (coarse * view.pixels) / distance;
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
