/** Points in a box, from below to above: the height of the ground, and of an object on it. */
import { Vector3, type Matrix4 } from 'three';
import type { CloudFrame } from '../cloud/frame';
import { inBox } from '../cloud/pick';
import { standing, toSource, type Volume } from './volume';

/** Parts of the points that may be strays below the ground and above an object. */
const [STRAYS_BELOW, STRAYS_ABOVE] = [0.03, 0.003];
/** The ground is looked for in a footprint so many times as wide: beside the object too. */
const BESIDE = 1.5;
/** The bottom stands over the ground by this part of the height, at most so many metres. */
const [CLEARANCE, MOST_CLEARANCE] = [0.06, 0.06];
/** A column reaches so many times its wider edge up and down. */
const TALL = 2;
/** Of points on one surface a box is at least so high, as a part of its wider edge. */
const LEAST_HEIGHT = 0.1;
/** Air of this part of the wider edge ends an object: what is above is a ceiling, or a branch. */
const GAP = 0.25;

/** Heights in the room of a frame's points in a box, ascending; `room`: `T_room_local`. */
export function heightsIn(frame: CloudFrame, room: Matrix4, volume: Volume): Float64Array {
  const { center, size, quaternion } = toSource(volume, room, [0, 0, 0]);
  const heights: number[] = [];
  const at = new Vector3();
  inBox(frame, center, size, quaternion, (point) => {
    const piece = frame.pieceOf(point);
    if (!piece) return;
    const { words, origin, scale, first } = piece;
    const w = 6 * (point - first);
    at.set(
      origin[0] + words[w]! * scale[0],
      origin[1] + words[w + 1]! * scale[1],
      origin[2] + words[w + 2]! * scale[2],
    );
    heights.push(at.applyMatrix4(room).y);
  });
  return Float64Array.from(heights).sort();
}

/** The box standing on the ground under it, without the ground's own points; itself over nothing. */
export function onGround(frame: CloudFrame, room: Matrix4, volume: Volume): Volume {
  const [x, y, z] = volume.size;
  const below: Volume = {
    ...volume,
    center: [volume.center[0], volume.center[1] - y / 2, volume.center[2]],
    size: [BESIDE * x, 2 * Math.max(x, y, z), BESIDE * z],
  };
  const heights = heightsIn(frame, room, below);
  if (heights.length === 0) return volume;
  const ground = heights[Math.floor(STRAYS_BELOW * (heights.length - 1))]!;
  const top = volume.center[1] + y / 2;
  if (top <= ground) return volume;
  return standing(volume, ground + Math.min(MOST_CLEARANCE, CLEARANCE * (top - ground)));
}

/** The height that what stands on `bottom` reaches, before the air above it. */
function topOf(heights: Float64Array, bottom: number, wide: number): number {
  const last = Math.round((1 - STRAYS_ABOVE) * (heights.length - 1));
  for (let i = 0; i < last; i++) {
    const high = heights[i]! - bottom > LEAST_HEIGHT * wide;
    if (high && heights[i + 1]! - heights[i]! > GAP * wide) return heights[i]!;
  }
  return heights[last]!;
}

/** A box over the same footprint, from the ground under it to the top of what stands there. */
export function fitted(frame: CloudFrame, room: Matrix4, volume: Volume): Volume {
  const wide = Math.max(volume.size[0], volume.size[2]);
  const column: Volume = { ...volume, size: [volume.size[0], 2 * TALL * wide, volume.size[2]] };
  const heights = heightsIn(frame, room, column);
  if (heights.length === 0) return volume;
  const bottom = heights[Math.floor(STRAYS_BELOW * (heights.length - 1))]!;
  const height = Math.max(LEAST_HEIGHT * wide, topOf(heights, bottom, wide) - bottom);
  const { center, size } = volume;
  const box: Volume = {
    ...volume,
    center: [center[0], bottom + height / 2, center[2]],
    size: [size[0], height * 1.02, size[2]],
  };
  return onGround(frame, room, box);
}
