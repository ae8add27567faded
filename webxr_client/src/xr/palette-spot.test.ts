import { Matrix4, Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import { palmFacing, PaletteSpot } from './palette-spot';

const seconds = Float64Array.of(0.1);
const [SIDEWAYS, TO_THE_EYES] = [0, 0.9];

describe('the palette', () => {
  it('is over the hand, hidden while one paints, and beside the timeline once the hand is missing', () => {
    const spot = new PaletteSpot();
    expect(spot.update(true, false, SIDEWAYS, seconds)).toBe('hand');
    expect(spot.update(true, true, SIDEWAYS, seconds)).toBe('away');
    const without = Array.from({ length: 9 }, () => spot.update(false, false, SIDEWAYS, seconds));
    expect(without[0]).toBe('away');
    expect(without.at(-1)).toBe('beside');
    expect(spot.update(true, false, SIDEWAYS, seconds)).toBe('hand');
  });

  it('is beside the timeline at once where there never was a hand', () => {
    expect(new PaletteSpot().update(false, false, SIDEWAYS, seconds)).toBe('beside');
  });

  it('stays put away until the palm is turned to the eyes anew', () => {
    const spot = new PaletteSpot();
    spot.update(true, false, TO_THE_EYES, seconds);
    spot.putAway = true;
    expect(spot.update(true, false, TO_THE_EYES, seconds)).toBe('away');
    expect(spot.update(true, false, SIDEWAYS, seconds)).toBe('away');
    expect(spot.update(true, false, TO_THE_EYES, seconds)).toBe('hand');
    expect(spot.update(true, false, SIDEWAYS, seconds)).toBe('hand');
  });

  it('tells a palm that faces the eyes from the back of a hand, on either side', () => {
    const eyes = new Vector3(0, 1.6, 0);
    const up = new Matrix4().makeRotationZ(Math.PI / 2).setPosition(0, 1.2, 0);
    expect(palmFacing(up, 'left', eyes)).toBeCloseTo(1);
    expect(palmFacing(up, 'right', eyes)).toBeCloseTo(-1);
    const level = new Matrix4().setPosition(0, 1.2, 0);
    expect(palmFacing(level, 'left', eyes)).toBeCloseTo(0);
  });
});
