/** The space before the head that all eyes see; places are in the head's own space, metres. */
import type { Camera, Vector3 } from 'three';

/** Metres from the middle of the head to an eye. */
const EYE = 0.035;
/** Distance from the picture's edge of all that is kept inside: a tangent. */
const MARGIN = 0.03;
const [LEFT, RIGHT, DOWN, UP] = [0, 1, 2, 3] as const;

export class Sight {
  /** Tangents of the angles to the picture's edges, of the eye that sees least. */
  private readonly edges = Float64Array.of(1, 1, 1, 1);

  /** `eyes`: a camera for each. */
  take(eyes: readonly Pick<Camera, 'projectionMatrix'>[]): void {
    const { edges } = this;
    edges.fill(Infinity);
    for (let i = 0; i < eyes.length; i++) {
      const e = eyes[i]!.projectionMatrix.elements;
      edges[LEFT] = Math.min(edges[LEFT]!, (1 - e[8]) / e[0]);
      edges[RIGHT] = Math.min(edges[RIGHT]!, (1 + e[8]) / e[0]);
      edges[DOWN] = Math.min(edges[DOWN]!, (1 - e[9]) / e[5]);
      edges[UP] = Math.min(edges[UP]!, (1 + e[9]) / e[5]);
    }
  }

  /** Angle below straight ahead to the picture's lower edge. */
  get down(): number {
    return Math.atan(this.edges[DOWN]!);
  }

  /** Increase `shift`, right and up, to the distance by which a place is outside the pictures. */
  lacks({ x, y, z }: Vector3, shift: Float64Array): void {
    const { edges } = this;
    const side = -z * MARGIN + EYE;
    const level = -z * MARGIN;
    const right = Math.min(0, -z * edges[RIGHT]! - side - x) + Math.max(0, z * edges[LEFT]! + side - x); // prettier-ignore
    const up = Math.min(0, -z * edges[UP]! - level - y) + Math.max(0, z * edges[DOWN]! + level - y);
    if (Math.abs(right) > Math.abs(shift[0]!)) shift[0] = right;
    if (Math.abs(up) > Math.abs(shift[1]!)) shift[1] = up;
  }
}
