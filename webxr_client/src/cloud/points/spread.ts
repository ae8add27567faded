/** Range of most of a frame's values, over which ramps of colour run. */
import type { Matrix4 } from 'three';
import type { CloudFrame } from './frame';

/** Points looked at. */
const SAMPLES = 4000;
/** Parts of the points below and above which values are strays. */
const [LOW, HIGH] = [0.02, 0.98];

export interface Spread {
  /** Metres above the room's floor. */
  readonly height: readonly [low: number, high: number];
  /** 0..1. */
  readonly intensity: readonly [low: number, high: number];
}

/** The spread of a frame's coarsest points, which are an even part of it; null without any. */
export function spreadOf(frame: CloudFrame, room: Matrix4): Spread | null {
  const piece = frame.pieces[0];
  if (!piece || piece.count === 0) return null;
  const step = Math.max(1, Math.floor(piece.count / SAMPLES));
  const samples = Math.ceil(piece.count / step);
  const heights = new Float32Array(samples);
  const intensities = new Float32Array(samples);
  const { words, origin, scale } = piece;
  const e = room.elements;
  for (let k = 0; k < samples; k++) {
    const at = 6 * k * step;
    const x = origin[0] + words[at]! * scale[0];
    const y = origin[1] + words[at + 1]! * scale[1];
    const z = origin[2] + words[at + 2]! * scale[2];
    heights[k] = e[1] * x + e[5] * y + e[9] * z + e[13];
    intensities[k] = (words[at + 4]! >> 8) / 255;
  }
  return { height: between(heights), intensity: between(intensities) };
}

function between(values: Float32Array): readonly [number, number] {
  values.sort();
  const at = (part: number): number => values[Math.round(part * (values.length - 1))]!;
  return [at(LOW), at(HIGH)];
}
