/** The first standpoint. */
import type { Matrix4, Vector3 } from 'three';
import type { CloudFrame } from '../../cloud/points/frame';
import { samplePoints } from '../../cloud/points/samples';
import { viewOf } from '../../view/framing';
import type { Rig } from './rig';

const SAMPLES = 3000;
/** Half the width of the path ahead, and heights of obstacles on it: above a floor, below a lamp. */
const HALF_PATH_METRES = 1.2;
const [LOW, HIGH] = [0.3, 2];
/** Stray points do not count. */
const PART = 0.05;

/** Metres from `eye` along a level `way` to the nearest things at body height, in the scene. */
function nearest(frame: CloudFrame, sceneFromLocal: Matrix4, eye: Vector3, way: Vector3): number {
  const found: number[] = [];
  for (const at of samplePoints(frame, sceneFromLocal, SAMPLES)) {
    if (at.y < LOW || at.y > HIGH) continue;
    at.sub(eye).setY(0);
    const along = at.dot(way);
    if (along > 0.2 && at.addScaledVector(way, -along).length() < HALF_PATH_METRES)
      found.push(along);
  }
  found.sort((a, b) => a - b);
  return found[Math.floor(PART * found.length)] ?? 0;
}

/** Look at a place of the scene from a level distance, with the eyes `rise` over it for a metre along. */
export function standRound(place: Vector3, distance: number, rise: number, rig: Rig): void {
  const way = place.clone().sub(rig.head).setY(0);
  if (way.lengthSq() === 0) way.copy(rig.ahead);
  way.normalize();
  rig.standAt(place.clone().addScaledVector(way, -distance), way);
  rig.liftTo(rig.group.position.y + place.y + rise * distance - rig.head.y);
}

/** One stands so far before the nearest things, metres. */
const ARM = 0.9;

/**
 * Stand on the sensor's line of sight, within reach of its points; false without points.
 * `shift`: source minus local.
 */
export function standBefore(
  frame: CloudFrame,
  sceneFromLocal: Matrix4,
  rig: Rig,
  shift: readonly number[],
): boolean {
  const seen = viewOf('sensor', frame, sceneFromLocal, 60, 1, shift);
  if (!seen) return false;
  const way = seen.target.clone().sub(seen.eye).setY(0);
  const length = way.length();
  way.normalize();
  const near = nearest(frame, sceneFromLocal, seen.eye, way);
  const ahead = Math.max(0, Math.min(length, near) - ARM);
  rig.standAt(seen.eye.clone().addScaledVector(way, ahead), way);
  return true;
}
