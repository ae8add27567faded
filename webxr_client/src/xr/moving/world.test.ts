import { Group, Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import { AirLasso } from '../painting/air';
import { resetWorld, scaleAbout, WorldGrab } from './world';
import { Matrix4 } from 'three';

const v = (x: number, y: number, z: number): Vector3 => new Vector3(x, y, z);

/** Move a place of the world to the scene. */
function seen(world: Group, at: Vector3): number[] {
  world.updateMatrixWorld(true);
  return world
    .localToWorld(at.clone())
    .toArray()
    .map((value) => Math.round(value * 1e4) / 1e4 + 0);
}

describe('holding the world', () => {
  it('drags it with one hand', () => {
    const world = new Group();
    const grab = new WorldGrab();
    grab.update(world, v(0, 1, 0), null);
    grab.update(world, v(0.5, 1, -1), null);
    expect(world.position.toArray()).toEqual([0.5, 0, -1]);
    // A hand that grips anew does not pull it along.
    grab.update(world, null, null);
    grab.update(world, v(3, 3, 3), null);
    expect(world.position.toArray()).toEqual([0.5, 0, -1]);
  });

  it('scales and turns it with two; what is held stays in the hands', () => {
    const world = new Group();
    const grab = new WorldGrab();
    grab.update(world, v(-0.5, 1, 0), v(0.5, 1, 0));
    const grown = grab.update(world, v(0, 1, 1), v(0, 1, -1));
    expect(grown).toBeCloseTo(2);
    expect(world.scale.x).toBeCloseTo(2);
    expect(seen(world, v(-0.5, 1, 0))).toEqual([0, 1, 1]);
    expect(seen(world, v(0.5, 1, 0))).toEqual([0, 1, -1]);
  });

  it('scales about a place that stays, and goes back', () => {
    const world = new Group();
    scaleAbout(world, 0.1, v(1, 0.8, -1));
    expect(seen(world, v(1, 0.8, -1))).toEqual([1, 0.8, -1]);
    resetWorld(world);
    expect(seen(world, v(1, 2, 3))).toEqual([1, 2, 3]);
  });
});

describe('a lasso in the air', () => {
  it('becomes an outline that encloses what lies behind it, seen from the head', () => {
    const lasso = new AirLasso();
    lasso.begin();
    for (const [x, y] of [
      [-0.2, 1.3],
      [0.2, 1.3],
      [0.2, 1.7],
      [-0.2, 1.7],
    ] as const)
      lasso.add(v(x, y, -0.5));
    const shift: [number, number, number] = [100, 0, 0];
    const drawn = lasso.end(v(0, 1.5, 0), new Matrix4(), { shift } as never)!;
    expect(drawn.polygon).toHaveLength(4);
    const clip = new Matrix4().set(...(drawn.matrix as Parameters<Matrix4['set']>));
    const at = v(100, 1.5, -2).applyMatrix4(clip);
    const xs = drawn.polygon.map(([x]) => x);
    expect(Math.abs(at.x)).toBeLessThan(Math.max(...xs));
    expect(Math.max(...xs)).toBeCloseTo(-Math.min(...xs));
    expect(lasso.add(v(-0.2, 1.701, -0.5))).toBe(false);
  });
});
