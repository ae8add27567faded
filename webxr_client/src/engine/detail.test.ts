import { Frustum, Matrix4, PerspectiveCamera, Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import { nodeOf, type OctreeNode, type View, worthwhile } from './detail';

/** A flat octree, 64 m wide: every node has 20,000 points and four children, on four levels. */
function tree(): OctreeNode[] {
  const nodes: OctreeNode[] = [];
  const grow = (x: number, y: number, size: number, parent: number, level: number): void => {
    const index = nodes.length;
    const [lo, hi] = [[x, y, 0] as const, [x + size, y + size, 1] as const];
    nodes.push(nodeOf({ index, count: 20_000, lo, hi, parent, sensor: null }));
    if (level === 3) return;
    for (const [i, j] of [[0, 0], [0, 1], [1, 0], [1, 1]] as const) {
      grow(x + (i * size) / 2, y + (j * size) / 2, size / 2, index, level + 1);
    } // prettier-ignore
  };
  grow(0, 0, 64, -1, 0);
  return nodes;
}

function viewFrom(eye: Vector3, target: Vector3): View {
  const camera = new PerspectiveCamera(55, 1.6, 0.05, 500);
  camera.up.set(0, 0, 1);
  camera.position.copy(eye);
  camera.lookAt(target);
  camera.updateMatrixWorld();
  const matrix = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
  return { eye, frustum: new Frustum().setFromProjectionMatrix(matrix), pixels: 700 };
}

const NODES = tree();
const ABOVE = viewFrom(new Vector3(32, 32, 60), new Vector3(32, 33, 0));
const NEAR = viewFrom(new Vector3(4, 4, 3), new Vector3(6, 6, 0.5));

describe('the chunks worth their points', () => {
  it('keep the budget, whatever it is, and never leave out the root', () => {
    for (const budget of [1, 100_000, 500_000, 10_000_000]) {
      const chosen = worthwhile(NODES, ABOVE, budget);
      expect(chosen[0]!.index).toBe(0);
      expect(chosen.length * 20_000).toBeLessThanOrEqual(Math.max(20_000, budget));
    }
  });

  it('hang together: nothing without what is above it', () => {
    for (const view of [ABOVE, NEAR]) {
      const chosen = new Set(worthwhile(NODES, view, 400_000).map((node) => node.index));
      for (const index of chosen) {
        const { parent } = NODES[index]!;
        if (parent >= 0) expect(chosen.has(parent)).toBe(true);
      }
    }
  });

  it('are the finest where one stands, and only in view', () => {
    const budget = 100_000;
    const finest = (view: View): number =>
      Math.min(...worthwhile(NODES, view, budget).map((node) => node.spacing));
    expect(finest(NEAR)).toBeLessThan(0.5 * finest(ABOVE));
    const behind = worthwhile(NODES, NEAR, Infinity).filter((node) => node.box.max.x < 3);
    expect(behind).toEqual([]);
  });

  it('are not finer than one can see', () => {
    const far = viewFrom(new Vector3(32, 32, 450), new Vector3(32, 33, 0));
    expect(worthwhile(NODES, far, Infinity).length).toBeLessThan(NODES.length / 2);
  });
});
