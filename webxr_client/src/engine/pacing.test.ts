import { PerspectiveCamera } from 'three';
import { describe, expect, it, vi } from 'vitest';
import type { Viewer } from '../cloud/picture/viewer';
import { ALL_POINTS } from '../cloud/points/frame';
import type { Playback } from './playback';
import { FEWEST_POINTS, Pacing, PointBudget } from './pacing';

const TARGET = 1000 / 72;

/** A display that draws `rate` points a millisecond, in whole multiples of its refresh. */
class Display {
  now = 0;
  drawn = 0;
  readonly budget = new PointBudget();

  constructor(
    public rate: number,
    readonly available = 1_000_000,
    /** Drawn only whole levels, which double. */
    readonly levels = false,
    readonly refresh = TARGET,
    /** Milliseconds of a picture that points have no part in. */
    public rest = 0,
  ) {}

  run(seconds: number): void {
    const stop = this.now + seconds * 1000;
    while (this.now < stop) {
      this.drawn = Math.min(this.available, this.budget.points);
      if (this.levels) {
        let level = this.available;
        while (level > this.drawn) level /= 2;
        this.drawn = level;
      }
      const interval =
        Math.ceil((this.rest + this.drawn / this.rate) / this.refresh) * this.refresh;
      this.now += interval;
      this.budget.note(Float64Array.of(interval, TARGET, this.now), this.drawn);
    }
  }

  /** Pictures of the next seconds that were late. */
  late(seconds: number): number {
    let late = 0;
    let all = 0;
    const stop = this.now + seconds * 1000;
    while (this.now < stop) {
      const before = this.now;
      this.run(1e-6);
      all += 1;
      if (this.now - before > 1.01 * TARGET) late += 1;
    }
    return late / all;
  }
}

describe('the budget of points', () => {
  it('leaves alone a display that is in time', () => {
    const display = new Display(1e6);
    display.run(10);
    expect(display.budget.points).toBe(ALL_POINTS);
  });

  it.each([false, true])('finds what a slow display can draw (whole levels: %s)', (levels) => {
    const display = new Display(300_000 / TARGET, 1_000_000, levels);
    display.run(4);
    display.run(60);
    expect(display.late(10)).toBeLessThan(0.1);
    expect(display.drawn).toBeGreaterThan(levels ? 240_000 : 150_000);
  });

  it('comes down within a second', () => {
    const display = new Display(100_000 / TARGET);
    display.run(1.5);
    expect(display.late(0.5)).toBeLessThan(0.5);
  });

  it('recovers when the display does', () => {
    const display = new Display(100_000 / TARGET);
    display.run(5);
    expect(display.drawn).toBeLessThan(150_000);
    display.rate = 1e6;
    display.run(60);
    expect(display.drawn).toBe(1_000_000);
    expect(display.budget.points).toBe(ALL_POINTS);
  });

  it('takes no points away when that does not help: a display of 30 pictures a second', () => {
    const display = new Display(1e6, 1_000_000, false, 1000 / 30);
    display.run(20);
    expect(display.drawn).toBe(1_000_000);
    // If points become the cause later, they are reduced after all.
    display.rate = 10_000;
    display.run(5);
    expect(display.drawn).toBeLessThan(500_000);
  });

  it('keeps points whose share of a slow picture is small', () => {
    const display = new Display(1_000_000 / 700, 1_000_000, false, 1, 300);
    display.run(60);
    expect(display.drawn).toBeGreaterThan(150_000);
    expect(display.drawn).toBeLessThan(700_000);
  });

  it('gives points back when what is left is not theirs', () => {
    const display = new Display(1000, 1_000_000, true, 1);
    display.run(20);
    expect(display.drawn).toBeLessThan(40_000);
    display.rate = 20_000;
    display.rest = 400;
    display.run(60);
    expect(display.drawn).toBeGreaterThan(400_000);
  });

  it('never draws nothing', () => {
    const display = new Display(1);
    display.run(60);
    expect(display.drawn).toBeGreaterThanOrEqual(FEWEST_POINTS);
  });
});

describe('a slow display', () => {
  /** Pictures of 400 ms of a million points. */
  function slow() {
    const camera = new PerspectiveCamera();
    const intervalMs = { total: 0, last: (out: Float64Array) => (out[0] = 400) };
    const renderer = { xr: { isPresenting: false } };
    const setLimit = vi.fn<(points: number) => void>();
    const viewer = { software: true, camera, intervalMs, renderer, setLimit, drawn: 1_000_000 };
    const playback = { pointBudget: null } as unknown as Playback;
    const pacing = new Pacing(viewer as unknown as Viewer, playback);
    let now = 1000;
    const pictures = (count: number, step: () => void = () => undefined): void => {
      for (let k = 0; k < count; k++) {
        step();
        camera.updateMatrixWorld();
        intervalMs.total += 1;
        pacing.update((now += 400));
      }
    };
    const limit = (): number => setLimit.mock.lastCall![0];
    return { camera, pictures, limit };
  }

  it('draws fewer points while the camera moves, and all of them under a still one', () => {
    const { camera, pictures, limit } = slow();
    pictures(1);
    // Aiming and painting change the picture, but not the camera.
    pictures(20);
    expect(limit()).toBe(ALL_POINTS);
    pictures(20, () => (camera.position.x += 0.1));
    expect(limit()).toBeLessThan(1_000_000);
    pictures(2);
    expect(limit()).toBe(ALL_POINTS);
  });
});
