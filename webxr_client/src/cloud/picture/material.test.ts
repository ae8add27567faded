import { describe, expect, it } from 'vitest';
import { PaletteTexture } from './palette';
import { PointUniforms } from './material';

describe('the widest discs', () => {
  const widest = (points: number, height = 900): number => {
    const uniforms = new PointUniforms(new PaletteTexture().texture);
    uniforms.setPoints(points);
    uniforms.setViewport(height);
    return uniforms.settings.value[2]!;
  };

  it('fill the near surfaces of dense frames, and are dots in sparse ones', () => {
    expect(widest(200_000)).toBeGreaterThan(20);
    expect(widest(5_800)).toBeLessThan(10);
    expect(widest(600)).toBeLessThan(10);
    expect(widest(1)).toBeGreaterThan(5);
  });

  it('are as wide on a display of more pixels', () => {
    expect(widest(600, 1800)).toBe(2 * widest(600));
  });
});
