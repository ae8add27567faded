import { afterEach, describe, expect, it, vi } from 'vitest';
import { DARK_INK, drawTimeline, type TimelinePicture } from './draw';
import { atNextPicture } from './next-picture';

/** A canvas that records texts and their places. */
function recorder() {
  const words: [text: string, x: number][] = [];
  const pen = new Proxy(
    {},
    {
      get: (_, name) => {
        if (name === 'measureText') return (text: string) => ({ width: 6 * text.length });
        if (name === 'fillText') return (text: string, x: number) => words.push([text, x]);
        return () => undefined;
      },
      set: () => true,
    },
  );
  return { words, pen: pen as unknown as CanvasRenderingContext2D };
}

function drawn(frame: number, first: number) {
  const { words, pen } = recorder();
  const sizes = { width: 1000, height: 120, gutter: 0, ruler: 26, row: 18, font: 'x', fontSize: 11, ink: DARK_INK }; // prettier-ignore
  const picture: TimelinePicture = {
    span: { first, length: 100 },
    frames: 2000,
    frame,
    loaded: [],
    range: null,
    labels: [],
    rows: new Map(),
    active: 0,
    scroll: 0,
  };
  drawTimeline(pen, sizes, picture);
  return words;
}

describe('the playhead', () => {
  it('is drawn in its place, and not at all outside the frames shown', () => {
    expect(drawn(955, 900)).toContainEqual(['955', 555]);
    for (const frame of [0, 899, 1000]) {
      expect(drawn(frame, 900).map(([text]) => text)).not.toContain(String(frame));
    }
  });
});

describe('strips', () => {
  afterEach(() => vi.unstubAllGlobals());

  it('are drawn in the next picture while values change before every one', () => {
    const waiting = new Map<number, () => void>();
    let count = 0;
    vi.stubGlobal('requestAnimationFrame', (run: () => void) => {
      waiting.set(++count, run);
      return count;
    });
    vi.stubGlobal('cancelAnimationFrame', (request: number) => waiting.delete(request));
    const seen: number[] = [];
    const strips = atNextPicture((value: number) => seen.push(value));
    strips.show(0);
    for (const change of [1, 2, 3]) {
      const now = [...waiting.keys()];
      strips.show(change); // as the picture of the cloud does, which comes first
      for (const request of now) {
        const run = waiting.get(request);
        waiting.delete(request);
        run?.();
      }
    }
    expect(seen).toEqual([1, 3]);
    strips.show(4);
    strips.stop();
    expect(waiting.size).toBe(0);
  });
});
