/** The palette's place: over a hand, beside the timeline, or put away. */
import type { Matrix4, Vector3 } from 'three';
import type { Side } from './settings';

export type Spot = 'hand' | 'beside' | 'away';

/** Seconds out of sight after which a hand counts as missing. */
const MISSING = 0.7;
/** Cosine between the palm and the eyes from which it is turned to them, and below which no more. */
const [TURNED, TURNED_AWAY] = [0.75, 0.5];

/**
 * Return how much a palm faces the eyes, −1 to 1.  A grip's x axis leaves the palm of the left hand and
 * enters that of the right one (WebXR: `gripSpace`).
 */
export function palmFacing(grip: Matrix4, side: Side | 'none', eyes: Vector3): number {
  const e = grip.elements;
  const x = eyes.x - e[12];
  const y = eyes.y - e[13];
  const z = eyes.z - e[14];
  const along = e[0] * x + e[1] * y + e[2] * z;
  const cosine = along / Math.max(1e-6, Math.sqrt(x * x + y * y + z * z));
  return side === 'right' ? -cosine : cosine;
}

export class PaletteSpot {
  /** A person put it away: a palm turned to the eyes brings it back. */
  putAway = false;
  private turned = false;
  /** Seconds since a hand was there to hold it. */
  private readonly missing = Float64Array.of(MISSING);

  /** Once per picture; `palm`: how much the holding hand's palm faces the eyes, while it is there. */
  update(there: boolean, painting: boolean, palm: number, seconds: Float64Array): Spot {
    this.missing[0] = there ? 0 : this.missing[0]! + seconds[0]!;
    const turned = there && palm > (this.turned ? TURNED_AWAY : TURNED);
    if (turned && !this.turned) this.putAway = false;
    this.turned = turned;
    if (painting || this.putAway) return 'away';
    if (there) return 'hand';
    return this.handless ? 'beside' : 'away';
  }

  /** No hand is there that could bring it back. */
  get handless(): boolean {
    return this.missing[0]! >= MISSING;
  }
}
