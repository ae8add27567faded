import type { Camera } from '../protocol/values';
import { describe, expect, it, vi } from 'vitest';
import { frameOf } from '../cloud/points/testing';
import { Lens } from './lens';

/** From a lidar (x ahead, z up) to a camera 10 cm above it. */
const AHEAD = [
  [0, -1, 0, 0],
  [0, 0, -1, 0.1],
  [1, 0, 0, 0],
  [0, 0, 0, 1],
];
const K = [
  [500, 0, 320],
  [0, 510, 240],
  [0, 0, 1],
];

function picture(fields: Partial<Camera> = {}): Camera {
  return { name: 'front', width: 640, height: 480, K, distortion: [], model: 'plumb_bob', T_camera_frame: AHEAD, ...fields }; // prettier-ignore
}

describe('a lens', () => {
  it('puts places where the camera sees them, also far from the origin', () => {
    const lens = Lens.of(picture(), [0, 0, 0])!;
    expect(lens.project(10, 2, 0.1)).toBe(true);
    expect([...lens.at]).toEqual([220, 240, 10]);
    expect(lens.project(-10, 2, 0)).toBe(false);
    expect(lens.project(10, 20, 0)).toBe(false);
    const far = AHEAD.map((row) => [...row]);
    far[0]![3] = 4_600_000;
    const moved = Lens.of(picture({ T_camera_frame: far }), [0, 4_600_000, 0])!;
    expect(moved.project(10, 2, 0.1)).toBe(true);
    expect([...moved.at]).toEqual([220, 240, 10]);
    expect(moved.eye.map((part) => part + 0)).toEqual([0, 0, 0.1]);
  });

  it.each([
    ['plumb_bob', [-0.3, 0.1, 0.001, -0.002, 0], 159.7923, 329.8691],
    ['rational_polynomial', [0.1, -0.05, 0.001, 0.001, 0.01, 0.2, -0.02, 0], 155.8977, 332.1758],
    ['equidistant', [0.05, -0.01, 0.002, 0], 159.715, 329.9199],
  ])('distorts as %s does', (model, distortion, column, row) => {
    const lens = Lens.of(picture({ model, distortion }), [0, 0, 0])!;
    expect(lens.project(6, 2, -1)).toBe(true);
    expect(lens.at[0]).toBeCloseTo(column, 3);
    expect(lens.at[1]).toBeCloseTo(row, 3);
  });

  it('leaves out what a strong distortion would fold back into the picture', () => {
    const lens = Lens.of(picture({ distortion: [-0.4, 0, 0, 0, 0] }), [0, 0, 0])!;
    expect(lens.project(1, 0.3, 0)).toBe(true);
    expect(lens.project(1, 1.5, 0)).toBe(false);
  });

  it('draws lines, without what is not in the picture', () => {
    const lens = Lens.of(picture(), [0, 0, 0])!;
    const [begin, ...rest] = lens.lines([4, -1, 0, 4, 1, 0]).split('L');
    expect(begin).toMatch(/^M/);
    expect(rest.length).toBeGreaterThan(1);
    expect(lens.lines([4, 0, 0, 4, 90, 0])).not.toContain('NaN');
    expect(lens.lines([-4, 0, 0, -4, 1, 0])).toBe('');
  });

  it('is not known without calibration, or with one of another kind', () => {
    expect(Lens.of(picture({ K: null }), [0, 0, 0])).toBeNull();
    expect(Lens.of(picture({ model: 'magic', distortion: [1] }), [0, 0, 0])).toBeNull();
  });
});

it('projects the nearest point of each pixel, and finds it again', async () => {
  vi.stubGlobal('ImageData', class {
    readonly data: Uint8ClampedArray;
    constructor(width: number, height: number) {
      this.data = new Uint8ClampedArray(width * height * 4);
    }
  }); // prettier-ignore
  const { placeOf, Projected } = await import('./projected');
  // Two points in line ahead of the camera, one to the left; millimetres.
  const frame = frameOf([[4000, 0, 100], [8000, 0, 100], [8000, 2000, 100]]); // prettier-ignore
  frame.setOverlay('paint', { indices: Uint32Array.of(0), values: Uint16Array.of(3) });
  const raster = new Projected(64, 48);
  const lens = Lens.of(picture(), [0, 0, 0])!;
  raster.draw(frame, lens, (label) => (label === 3 ? [255, 0, 0] : [9, 9, 9]));
  expect(raster.nearest(32, 24, 2)).toBe(0);
  expect(placeOf(frame, raster.nearest(19, 24, 2))).toEqual([8, 2, 0.1]);
  expect(raster.nearest(50, 40, 3)).toBe(-1);
  const at = (24 * 64 + 32) * 4;
  expect([...raster.pixels.data.slice(at, at + 3)]).toEqual([255, 0, 0]);
  raster.draw(frame, lens, (label) => (label === 3 ? null : [9, 9, 9]));
  expect(raster.nearest(32, 24, 2)).toBe(1);
});

it('draws dots at the points of an outlined piece alone, and clears their inside', async () => {
  const { Projected } = await import('./projected');
  const frame = frameOf([[4000, 0, 100], [8000, 0, 100], [8000, 2000, 100], [2000, 60_000, 0]]); // prettier-ignore
  const dots: [number, number][] = [];
  const strokes: [number, string][] = [];
  const pen = {
    beginPath: () => dots.splice(0), moveTo: (u: number, v: number) => dots.push([u, v]), lineTo: vi.fn(),
    stroke: () => strokes.push([pen.lineWidth, pen.globalCompositeOperation]), lineWidth: 0, globalCompositeOperation: '',
  }; // prettier-ignore
  new Projected(320, 240).outline(pen as never, frame, Lens.of(picture(), [0, 0, 0])!, Uint32Array.of(0, 2, 3)); // prettier-ignore
  expect(dots).toEqual([[160, 120], [97.5, 120]]); // prettier-ignore
  const [[outer], [inner, how]] = [strokes[0]!, strokes.at(-1)!];
  expect([inner < outer, how]).toEqual([true, 'destination-out']);
});
