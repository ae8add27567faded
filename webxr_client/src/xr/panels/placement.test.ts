import { Group, Matrix4, Object3D, PerspectiveCamera, Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import type { Panel } from './panel';
import { type PanelLevel, PaletteSpot, Placement, PLACEMENT } from './placement';
import type { Poses } from '../input/poses';
import { Rig } from '../moving/rig';
import { degrees, LEAST_DEGREES, SIZES } from '../drawing/sizes';
import { MODEL, placeModel } from '../moving/world';

const DEGREE = Math.PI / 180;
/** Half the timeline, metres. */
const [HALF_WIDTH, HALF_HEIGHT] = [0.53, 0.2525];

/** A rig with the eyes at a place, in the headset's own space. */
function standing(eyes: Vector3): Rig {
  const rig = new Rig();
  const head = new Matrix4().setPosition(eyes);
  const poses = { head: (out: Matrix4) => Boolean(out.copy(head)) };
  rig.update(poses as unknown as Poses);
  return rig;
}

/** An eye that sees so far down, degrees. */
function eye(down: number): PerspectiveCamera {
  return new PerspectiveCamera(2 * down);
}

type Placed = Record<'middle' | 'edge' | 'corner' | 'top', Vector3>;

function placed(eyes: Vector3, down = 45, level: PanelLevel = 'low'): Placed {
  const rig = standing(eyes);
  rig.sight.take([eye(down), eye(48)]);
  const mesh = new Object3D();
  const placement = new Placement(rig);
  placement.face();
  const size = { width: 2 * HALF_WIDTH, height: 2 * HALF_HEIGHT };
  placement.hangTimeline({ mesh, size } as unknown as Panel, level);
  return {
    middle: new Vector3().setFromMatrixPosition(mesh.matrix),
    edge: new Vector3(0, -HALF_HEIGHT, 0).applyMatrix4(mesh.matrix),
    corner: new Vector3(HALF_WIDTH, HALF_HEIGHT, 0).applyMatrix4(mesh.matrix),
    top: new Vector3(0, HALF_HEIGHT, 0).applyMatrix4(mesh.matrix),
  };
}

/** Angle below the eyes' height at which a place is seen, degrees. */
const below = (eyes: Vector3, place: Vector3): number =>
  Math.asin((eyes.y - place.y) / eyes.distanceTo(place)) / DEGREE;

describe('the timeline', () => {
  it.each([
    ['stands', 1.6],
    ['sits', 1.1],
    ['has no floor', 0],
  ])('hangs 15 to 30° below the eyes of who %s, and can be read', (_name, height) => {
    const eyes = new Vector3(0.3, height, -0.2);
    const { middle, corner } = placed(eyes);
    expect(below(eyes, middle)).toBeGreaterThanOrEqual(15);
    expect(below(eyes, middle)).toBeLessThanOrEqual(30);
    const distance = corner.distanceTo(eyes);
    expect(degrees({ ...SIZES.timeline, distance })).toBeGreaterThanOrEqual(LEAST_DEGREES);
  });

  it('has its handle in the picture, however little a device sees', () => {
    const eyes = new Vector3(0, 1.6, 0);
    for (const [sees, hangs] of [
      [50, 43],
      [30, 28],
    ] as const) {
      expect(below(eyes, placed(eyes, sees).edge)).toBeCloseTo(hangs);
    }
  });

  it('hides nothing of a model, folded or not', () => {
    const eyes = new Vector3(0, 1.6, 0);
    // A handle is 4° high, and may be between the model and the open timeline.
    const top = Math.min(PLACEMENT.edge / DEGREE, below(eyes, placed(eyes, 45, 'under').top)) - 4;
    for (const size of [2, 8, 40]) {
      const world = new Group();
      const bounds = [new Vector3(-size / 2, 0, 1), new Vector3(size / 2, 2, 1 + size)] as const;
      placeModel(world, 0.1, bounds, eyes, new Vector3(0, 0, -1));
      world.updateMatrixWorld();
      const near = new Vector3(0, 0, 1 + size).applyMatrix4(world.matrixWorld);
      near.z = Math.min(near.z, eyes.z - MODEL.nearest);
      expect(below(eyes, near), `a model of ${size} m`).toBeLessThan(top);
    }
  });

  it('leaves room for the handle of a palette that no hand holds', () => {
    const eyes = new Vector3(0, 1.6, 0);
    const { edge } = placed(eyes, 45, 'raised');
    expect(below(eyes, edge)).toBeLessThan(PLACEMENT.edge / DEGREE - 4);
  });

  it('follows the ray that carries it, turned to the eyes, by the place that is held', () => {
    const eyes = new Vector3(0, 1.6, 0);
    const rig = standing(eyes);
    const mesh = new Object3D();
    const held = { mesh, heldAt: { x: 0.1, y: -0.25 }, distance: Float64Array.of(1.2) };
    const by = { origin: new Vector3(0.2, 1.1, -0.2), direction: new Vector3(0.6, 0, -0.8) };
    new Placement(rig).carry(held as unknown as Panel, by);
    const bar = new Vector3(0.1, -0.25, 0).applyMatrix4(mesh.matrix);
    const met = by.origin.clone().addScaledVector(by.direction, 1.2);
    expect(bar.distanceTo(met)).toBeLessThan(1e-6);
    const facing = new Vector3().setFromMatrixColumn(mesh.matrix, 2).normalize();
    const way = eyes.clone().sub(new Vector3().setFromMatrixPosition(mesh.matrix)).normalize();
    expect(facing.dot(way)).toBeGreaterThan(0.99);
  });
});

const seconds = Float64Array.of(0.1);
const [SIDEWAYS, TO_THE_EYES] = [0, 0.9];

describe('the palette', () => {
  it('is over the hand, hidden while one paints, and beside the other handle once the hand is missing', () => {
    const spot = new PaletteSpot();
    expect(spot.update(true, false, SIDEWAYS, seconds)).toBe('hand');
    expect(spot.update(true, true, SIDEWAYS, seconds)).toBe('away');
    const without = Array.from({ length: 9 }, () => spot.update(false, false, SIDEWAYS, seconds));
    expect(without[0]).toBe('away');
    expect(without.at(-1)).toBe('beside');
    expect(spot.update(true, false, SIDEWAYS, seconds)).toBe('hand');
  });

  it('is beside the timeline at once where there never was a hand', () => {
    expect(new PaletteSpot().update(false, false, SIDEWAYS, seconds)).toBe('beside');
  });

  it('is asked for by a palm that is turned to the eyes for a moment, once', () => {
    const spot = new PaletteSpot();
    const requests = Array.from({ length: 9 }, () => {
      spot.update(true, false, TO_THE_EYES, seconds);
      return spot.isRequested;
    });
    expect(requests.filter(Boolean)).toHaveLength(1);
    expect(requests[0]).toBe(false);
  });

  it('is not asked for by a palm that is turned for a system gesture, which pinches at once', () => {
    const spot = new PaletteSpot();
    for (const palm of [TO_THE_EYES, TO_THE_EYES, 0, TO_THE_EYES, TO_THE_EYES, TO_THE_EYES]) {
      spot.update(true, false, palm, seconds);
      expect(spot.isRequested).toBe(false);
    }
  });
});

describe('a question', () => {
  const placeQuestion = (eyes: Vector3): { mesh: Object3D; placement: Placement; panel: Panel } => {
    const mesh = new Object3D();
    const placement = new Placement(standing(eyes));
    placement.face();
    const panel = { mesh, size: { width: 0.445, height: 0.204 } } as unknown as Panel;
    return { mesh, placement, panel };
  };

  it('hangs beside the whole of a model', () => {
    const eyes = new Vector3(0, 1.6, 0);
    const { mesh, placement, panel } = placeQuestion(eyes);
    const [middle, radius] = [new Vector3(0, 1.2, -1.2), 0.3];
    placement.layBeside(panel, middle, radius);
    const left = new Vector3(-0.2225, 0, 0).applyMatrix4(mesh.matrix);
    const right = new Vector3(0.2225, 0, 0).applyMatrix4(mesh.matrix);
    const aside = [left, right].map((edge) => Math.abs(Math.atan2(edge.x, -edge.z)));
    expect(Math.min(...aside)).toBeGreaterThan(Math.asin(radius / 1.2));
  });

  it.each([
    ['to the right of the eyes', 0.6],
    ['to the left of them', -0.6],
  ])('hangs beside an object %s, nearer to straight ahead, and hides none of it', (_where, x) => {
    const eyes = new Vector3(0, 1.6, 0);
    const { mesh, placement, panel } = placeQuestion(eyes);
    const object = new Vector3(x, 1.4, -1.5);
    placement.layBeside(panel, object);
    const middle = new Vector3().setFromMatrixPosition(mesh.matrix);
    const apart = middle.clone().sub(eyes).angleTo(object.clone().sub(eyes)) / DEGREE;
    // Half the panel is 15° wide.
    expect(apart).toBeGreaterThan(18);
    expect(apart).toBeLessThan(30);
    expect(Math.abs(middle.x)).toBeLessThan(Math.abs(x));
  });
});
