/** A gentle pulse of labels to review: their points, and their rows of the palette. */
import type { PointUniforms } from '../../cloud/picture/material';
import { unsure } from '../../engine/review';
import type { PalettePanel } from './palette-panel';

/** Calm breathing; faster would alarm, and flashes harm. */
const PERIOD_MS = 1600;

export class Pulse {
  constructor(
    private readonly uniforms: PointUniforms,
    private readonly palette: PalettePanel,
  ) {}

  /** Once per picture. */
  update(now: number): void {
    const on = unsure.peek().length > 0;
    const strength = on ? 0.5 - 0.5 * Math.cos((2 * Math.PI * now) / PERIOD_MS) : 0;
    this.uniforms.pulse = strength;
    this.palette.pulse(strength);
  }

  dispose(): void {
    this.uniforms.pulse = 0;
  }
}
