/** A sample of a frame's points, to find its orientation. */
import { type Matrix4, Vector3 } from 'three';
import type { CloudFrame } from './frame';
import type { Piece } from './piece';

/** Call `found` with about `most` of the coarsest points of all sensors, evenly taken. */
export function eachSample(
  { pieces }: CloudFrame,
  most: number,
  found: (piece: Piece, i: number) => void,
): void {
  const coarse = pieces.filter(({ level }) => level === pieces[0]!.level);
  const points = coarse.reduce((sum, { count }) => sum + count, 0);
  const step = Math.max(1, Math.floor(points / most));
  for (const piece of coarse) for (let i = 0; i < piece.count; i += step) found(piece, i);
}

/** The sample's points in the coordinates that `placed` leads to. */
export function samplePoints(frame: CloudFrame, placed: Matrix4, most: number): Vector3[] {
  const points: Vector3[] = [];
  eachSample(frame, most, ({ origin, scale, words }, i) => {
    const at = (k: 0 | 1 | 2): number => origin[k] + words[i * 6 + k]! * scale[k];
    points.push(new Vector3(at(0), at(1), at(2)).applyMatrix4(placed));
  });
  return points;
}
