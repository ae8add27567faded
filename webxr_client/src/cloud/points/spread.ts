/** Range of most of a frame's values, over which ramps of colour run. */
import type { Matrix4 } from 'three';
import type { CloudFrame } from './frame';
import { samplePoints } from './samples';

/** Number of sampled points. */
const SAMPLES = 4000;
/** Parts of the points below and above which values are strays. */
const [LOW, HIGH] = [0.02, 0.98];

export type Range = readonly [low: number, high: number];

export interface Spread {
  /** Metres above the room's floor. */
  readonly height: Range;
  /** 0..1. */
  readonly intensity: Range;
}

/** The spread of a frame's coarsest points, which are an even part of it; null without any. */
export function spreadOf(frame: CloudFrame, room: Matrix4): Spread | null {
  const piece = frame.pieces[0];
  if (!piece || piece.count === 0) return null;
  const step = Math.max(1, Math.floor(piece.count / SAMPLES));
  const heights = Float32Array.from(samplePoints(frame, room, SAMPLES), ({ y }) => y);
  const intensities = heights.map((_, k) => (piece.words[6 * k * step + 4]! >> 8) / 255);
  return { height: between(heights), intensity: between(intensities) };
}

function between(values: Float32Array): Range {
  values.sort();
  const at = (part: number): number => values[Math.round(part * (values.length - 1))]!;
  return [at(LOW), at(HIGH)];
}
