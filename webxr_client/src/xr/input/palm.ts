/** The palm of a hand: whether it faces the eyes, which is how system gestures begin. */
import type { Matrix4, Vector3 } from 'three';
import type { Side } from '../../store/xr-settings';

/** Cosine between the palm and the eyes from which a pinch is taken to be the system's: 37°. */
const FACING = 0.8;
/** Cosine between the eyes' direction and the hand from which it is looked at: 35°. */
const LOOKED_AT = 0.82;

/** The eyes in the headset's own space, and their direction, of unit length. */
export interface Eyes {
  readonly headInRig: Vector3;
  readonly gaze: Vector3;
}

/**
 * Degree to which a palm faces the eyes, −1 to 1.  A grip's x axis leaves the palm of the left hand and
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

/**
 * Whether a pinch that starts now is the system's: the palm faces the eyes, and they look at it.
 * A hand beside the head with its palm to the head is not looked at, and paints.
 */
export function pinchesForSystem(grip: Matrix4, side: Side | 'none', eyes: Eyes): boolean {
  if (palmFacing(grip, side, eyes.headInRig) < FACING) return false;
  const { gaze, headInRig } = eyes;
  const e = grip.elements;
  const x = e[12] - headInRig.x;
  const y = e[13] - headInRig.y;
  const z = e[14] - headInRig.z;
  const ahead = gaze.x * x + gaze.y * y + gaze.z * z;
  return ahead > LOOKED_AT * Math.sqrt(x * x + y * y + z * z);
}
