/** Views of a recording: the first one, which is the sensor's or an overview, and presets. */
import { signal } from '@preact/signals';
import { type Matrix4, Vector3 } from 'three';
import type { ViewPreset } from '../store/actions';
import type { CloudFrame } from '../cloud/points/frame';
import { samplePoints } from '../cloud/points/samples';

interface View {
  readonly eye: Vector3;
  readonly target: Vector3;
}

/** Number of points sampled to find the recording's orientation. */
const SAMPLES = 2000;
/** Mean of unit directions from a sensor that sees one way is longer than this. */
const ONE_WAY = 0.6;
/** Stray points beyond these parts of the others do not count. */
const [LOW, HIGH] = [0.04, 0.96];

/** The value below which a part of the values lies; sorts them. */
export function quantile(values: number[], part: number): number {
  values.sort((a, b) => a - b);
  return values[Math.floor(part * (values.length - 1))] ?? 0;
}

/**
 * From the sensor (the local origin): its own view if the points lie to one side of it, as a
 * camera's do; from behind and above it if they lie around it, as a lidar's do; else null.
 */
function sensorView(points: readonly Vector3[], room: Matrix4): View | null {
  const sensor = new Vector3().applyMatrix4(room);
  const mean = new Vector3();
  const distances: number[] = [];
  for (const point of points) {
    const distance = point.distanceTo(sensor);
    if (distance < 1e-6) continue;
    distances.push(distance);
    mean.addScaledVector(point, 1 / distance).addScaledVector(sensor, -1 / distance);
  }
  const [near, middle, far] = [0.05, 0.5, 0.95].map((part) => quantile(distances, part));
  if (!middle || !near || !far) return null;
  const oneWay = mean.length() / distances.length;
  const forward = mean.normalize();
  if (oneWay > ONE_WAY) {
    const target = forward.clone().multiplyScalar(middle).add(sensor);
    // A little behind the sensor, so that its whole picture fits with some room around.
    return { eye: sensor.addScaledVector(forward, -0.02 * middle), target };
  }
  // An origin far from all points is not the place of a sensor.
  if (oneWay > 0.9 || near > 0.3 * far) return null;
  const eye = new Vector3(-0.6, 0.75, 0.9).multiplyScalar(1.3 * middle).add(sensor);
  return { eye, target: sensor };
}

/** Whether a preset is a plan: orthographic, straight along an axis of the room. */
export function isPlan(preset: ViewPreset): boolean {
  return preset !== 'sensor' && preset !== 'fit';
}

/** The view that a preset asks for; room coordinates. `shift`: source minus local. */
export function viewOf(
  preset: ViewPreset,
  frame: CloudFrame,
  room: Matrix4,
  fov: number,
  aspect: number,
  shift: readonly number[],
): View | null {
  const points = samplePoints(frame, room, SAMPLES);
  if (points.length === 0) return null;
  // Coordinates of a map begin nowhere near a sensor.
  const local = shift.every((metres) => metres === 0);
  const sensor = preset === 'sensor' && local ? sensorView(points, room) : null;
  // An origin below all points is no place to look from.
  if (sensor && sensor.eye.y > quantile(points.map((p) => p.y), LOW)) return sensor; // prettier-ignore
  const bound = (part: number): Vector3 =>
    new Vector3(
      quantile(points.map((p) => p.x), part),
      quantile(points.map((p) => p.y), part),
      quantile(points.map((p) => p.z), part),
    ); // prettier-ignore
  const [low, high] = [bound(LOW), bound(HIGH)];
  const target = low.clone().add(high).multiplyScalar(0.5);
  const radius = Math.max(0.3, 0.55 * low.distanceTo(high));
  const half = Math.tan((fov * Math.PI) / 360) * Math.min(1, aspect);
  const eye = directionOf(preset)
    .multiplyScalar((radius / half) * 0.85)
    .add(target);
  return { eye, target };
}

function directionOf(preset: ViewPreset): Vector3 {
  switch (preset) {
    case 'top':
      return new Vector3(0, 1, 0);
    case 'front':
      return new Vector3(0, 0, 1);
    case 'left':
      return new Vector3(-1, 0, 0);
    case 'right':
      return new Vector3(1, 0, 0);
    default:
      return new Vector3(0.45, 0.5, 0.75).normalize();
  }
}

/** The picture is orthographic; the engine writes it. */
export const orthographic = signal(false);
