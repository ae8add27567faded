/** Where to look from: the sensor's own view where there is one, else an overview. */
import { Vector3, type Matrix4 } from 'three';
import type { CloudFrame } from '../cloud/frame';
import type { ViewPreset } from '../actions';

export interface View {
  readonly eye: Vector3;
  readonly target: Vector3;
}

export interface Extent {
  readonly low: Vector3;
  readonly high: Vector3;
}

/** Points looked at to find out how the recording lies round its sensor. */
const SAMPLES = 2000;
/** Mean of unit directions from a sensor that sees one way is longer than this. */
const ONE_WAY = 0.6;

/**
 * The view of the sensor at the local origin, if the points lie to one side of it as a camera's
 * do; else null.  Room coordinates.
 */
export function sensorView(frame: CloudFrame, room: Matrix4, fov: number): View | null {
  const piece = frame.pieces[0];
  if (!piece) return null;
  const eye = new Vector3().applyMatrix4(room);
  const mean = new Vector3();
  const at = new Vector3();
  const distances: number[] = [];
  const step = Math.max(1, Math.floor(piece.count / SAMPLES));
  for (let i = 0; i < piece.count; i += step) {
    const word = (k: number): number =>
      piece.origin[k]! + piece.words[i * 6 + k]! * piece.scale[k]!;
    at.set(word(0), word(1), word(2)).applyMatrix4(room).sub(eye);
    const distance = at.length();
    if (distance < 1e-6) continue;
    distances.push(distance);
    mean.addScaledVector(at, 1 / distance);
  }
  if (distances.length === 0 || mean.length() / distances.length < ONE_WAY) return null;
  distances.sort((a, b) => a - b);
  const middle = distances[distances.length >> 1]!;
  const target = mean.normalize().multiplyScalar(middle).add(eye);
  // A little behind the sensor, so that its whole picture fits with some room around.
  eye.addScaledVector(mean, -0.02 * middle * (60 / fov));
  return { eye, target };
}

/** A view of the whole extent. */
export function presetView(preset: ViewPreset, extent: Extent, fov: number, aspect: number): View {
  const target = extent.low.clone().add(extent.high).multiplyScalar(0.5);
  const size = extent.high.clone().sub(extent.low);
  const radius = Math.max(0.3, 0.5 * Math.hypot(size.x, size.y, size.z));
  const half = Math.tan((fov * Math.PI) / 360) * Math.min(1, aspect);
  const distance = (radius / half) * 0.78;
  const eye = directionOf(preset).multiplyScalar(distance).add(target);
  return { eye, target };
}

function directionOf(preset: ViewPreset): Vector3 {
  switch (preset) {
    case 'top':
      return new Vector3(0, 1, 0.001);
    case 'front':
      return new Vector3(0, 0.05, 1).normalize();
    case 'left':
      return new Vector3(-1, 0.05, 0).normalize();
    case 'right':
      return new Vector3(1, 0.05, 0).normalize();
    default:
      return new Vector3(0.45, 0.5, 0.75).normalize();
  }
}
