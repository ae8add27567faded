import { describe, expect, it } from 'vitest';
import { PaletteTexture, PREDICTED, PREVIEW } from './palette';

describe('the palette', () => {
  it('lets rays meet what is previewed and predicted, whatever labels there are', () => {
    const palette = new PaletteTexture();
    palette.setPreview('#ff0000');
    palette.setPredicted(['#00ff00']);
    palette.set([], null, []);
    expect(palette.isShown(PREVIEW)).toBe(true);
    expect(palette.isShown(PREDICTED)).toBe(true);
  });

  it('keeps the preview’s colour when labels change', () => {
    const palette = new PaletteTexture();
    palette.setPreview('#ff0000');
    const before = [...palette.texture.image.data!.slice(4 * PREVIEW, 4 * PREVIEW + 4)];
    palette.set([], null, []);
    expect([...palette.texture.image.data!.slice(4 * PREVIEW, 4 * PREVIEW + 4)]).toEqual(before);
  });
});
