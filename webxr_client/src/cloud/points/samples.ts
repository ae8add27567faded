/** A sample of a frame's points, to find its orientation. */
import { type Matrix4, Vector3 } from 'three';
import type { CloudFrame } from './frame';

/** About `most` of the coarsest points, evenly taken, in the coordinates that `placed` leads to. */
export function samplePoints(frame: CloudFrame, placed: Matrix4, most: number): Vector3[] {
  const piece = frame.pieces[0];
  if (!piece) return [];
  const { count, origin, scale, words } = piece;
  const step = Math.max(1, Math.floor(count / most));
  const points: Vector3[] = [];
  for (let i = 0; i < count; i += step) {
    const at = (k: 0 | 1 | 2): number => origin[k] + words[i * 6 + k]! * scale[k];
    points.push(new Vector3(at(0), at(1), at(2)).applyMatrix4(placed));
  }
  return points;
}
