/** Moving the recording with the hands: one drags it, two turn and scale it as well. */
import { Quaternion, Vector3, type Group } from 'three';

const MIN_SCALE = 0.02;
const MAX_SCALE = 50;
const UP = new Vector3(0, 1, 0);

/** The held places of the last frame. */
export class WorldGrab {
  private held = 0;
  private readonly a = new Vector3();
  private readonly b = new Vector3();
  private readonly before = new Vector3();
  private readonly after = new Vector3();
  private readonly turn = new Quaternion();

  /** Whether a hand holds the world. */
  get active(): boolean {
    return this.held > 0;
  }

  /**
   * Move `world` so that it follows the places that hold it (null: that hand lets go).  Returns by
   * how much it grew.
   */
  update(world: Group, one: Vector3 | null, two: Vector3 | null): number {
    const held = (one ? 1 : 0) | (two ? 2 : 0);
    const same = held === this.held;
    this.held = held;
    let grown = 1;
    if (same && held === 3) grown = this.both(world, one!, two!);
    else if (same && held !== 0)
      world.position.add(this.after.subVectors((one ?? two)!, one ? this.a : this.b));
    if (one) this.a.copy(one);
    if (two) this.b.copy(two);
    return grown;
  }

  private both(world: Group, one: Vector3, two: Vector3): number {
    const { before, after, turn } = this;
    before.subVectors(this.b, this.a);
    after.subVectors(two, one);
    const wanted = after.length() / Math.max(1e-3, before.length());
    const scale = Math.min(MAX_SCALE, Math.max(MIN_SCALE, world.scale.x * wanted));
    const grown = scale / world.scale.x;
    // Turned about the vertical only: the floor stays level.
    const angle = Math.atan2(before.z, before.x) - Math.atan2(after.z, after.x);
    turn.setFromAxisAngle(UP, angle);
    before.addVectors(this.a, this.b).multiplyScalar(0.5);
    after.addVectors(one, two).multiplyScalar(0.5);
    world.position.sub(before).multiplyScalar(grown).applyQuaternion(turn).add(after);
    world.quaternion.premultiply(turn);
    world.scale.setScalar(scale);
    return grown;
  }
}

/** Scale about a place that stays where it is. */
export function scaleAbout(world: Group, scale: number, place: Vector3): void {
  const grown = scale / world.scale.x;
  world.position.sub(place).multiplyScalar(grown).add(place);
  world.scale.setScalar(scale);
}

/** Lengths in metres, the angle in radians. */
export const MODEL = {
  /** From the eyes to a model's nearest side, and to its middle at least and at most. */
  nearest: 0.45,
  middle: [0.9, 1.6],
  /** Angle of its bottom's nearest side below the eyes: panels further down do not hide it. */
  below: Math.PI / 6,
} as const;

/**
 * Put the recording before the person as a model of its size times `scale`.  `low` and `high` are the
 * corners of its bounds in the world, `ahead` is level.
 */
export function placeModel(
  world: Group,
  scale: number,
  [low, high]: readonly [Vector3, Vector3],
  eyes: Vector3,
  ahead: Vector3,
): void {
  const half = (Math.hypot(high.x - low.x, high.z - low.z) / 2) * scale;
  const [least, most] = MODEL.middle;
  const distance = Math.min(most, Math.max(least, MODEL.nearest + half));
  const bottom = low.clone().add(high).multiplyScalar(0.5).setY(low.y);
  const place = eyes.clone().addScaledVector(ahead, distance);
  place.y -= Math.tan(MODEL.below) * Math.max(MODEL.nearest, distance - half);
  world.scale.setScalar(scale);
  world.position.copy(place).sub(bottom.multiplyScalar(scale).applyQuaternion(world.quaternion));
}

/** 1:1, upright, on the floor. */
export function resetWorld(world: Group): void {
  world.position.set(0, 0, 0);
  world.quaternion.identity();
  world.scale.setScalar(1);
}
