import { describe, expect, it } from 'vitest';
import { contrast, LABEL_COLORS } from '../panels/colors';
import { SIZES } from './sizes';
import { INK } from './ui';

describe('panels in the room', () => {
  it.each(Object.entries(SIZES))('have text of a degree or more: %s', (_name, { em, away }) => {
    expect((Math.atan2(em, away) * 180) / Math.PI).toBeGreaterThan(1);
  });

  it('have text that contrasts with whatever lies under it', () => {
    for (const back of [INK.back, INK.raised, INK.hover]) {
      expect(contrast(INK.text, back)).toBeGreaterThan(7);
      expect(contrast(INK.quiet, back)).toBeGreaterThan(4.5);
    }
    expect(contrast(INK.accent, INK.on)).toBeGreaterThan(4.5);
    expect(contrast(INK.quiet, INK.on)).toBeGreaterThan(4.5);
    expect(contrast(INK.off, INK.raised)).toBeGreaterThan(4.5);
    for (const color of [INK.bad, INK.good, INK.warn]) {
      expect(contrast(color, INK.back)).toBeGreaterThan(4.5);
    }
    for (const color of LABEL_COLORS) expect(contrast(color, INK.raised)).toBeGreaterThan(3);
  });
});
