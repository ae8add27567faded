/** Range of most of a frame's values, over which ramps of colour run. */
import type { Matrix4 } from 'three';
import type { CloudFrame } from './frame';
import { eachSample, samplePoints } from './samples';

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
  const heights = Float32Array.from(samplePoints(frame, room, SAMPLES), ({ y }) => y);
  if (heights.length === 0) return null;
  const intensities: number[] = [];
  eachSample(frame, SAMPLES, ({ words }, i) => intensities.push((words[6 * i + 4]! >> 8) / 255));
  return { height: between(heights), intensity: between(Float32Array.from(intensities)) };
}

function between(values: Float32Array): Range {
  values.sort();
  const at = (part: number): number => values[Math.round(part * (values.length - 1))]!;
  return [at(LOW), at(HIGH)];
}
