/** The display's refresh rate, measured where the browser does not tell it. */

/** Rates of headsets' displays, Hz. */
const RATES = [60, 72, 75, 80, 90, 120, 144] as const;
/** Intervals that are looked at. */
const SAMPLES = 60;
/** Minimum rate of displays: a lower rate means frames dropped by a busy page. */
const SLOWEST = 55;
/** Intervals up to this many times the shortest ones are of one refresh. */
const ONE_REFRESH = 1.4;

/** The display's rate, Hz, from milliseconds between pictures, some of which came late. */
export function rateOf(intervals: Float64Array): number {
  const sorted = intervals.slice().sort();
  const short = sorted[Math.floor(sorted.length / 10)]!;
  const single = sorted.filter((interval) => interval < ONE_REFRESH * short);
  let rate = 1000 / single[Math.floor(single.length / 2)]!;
  for (let of = 2; rate < SLOWEST && of <= 3; of++) {
    if (of * rate >= SLOWEST) rate *= of;
  }
  return RATES.reduce((best, one) => (Math.abs(one - rate) < Math.abs(best - rate) ? one : best));
}

export class RefreshRate {
  private readonly intervals = new Float64Array(SAMPLES);
  private count = -1;
  private readonly last = new Float64Array(1);

  /** Take in a picture's time, milliseconds; true when there were enough. */
  note(now: number): boolean {
    if (this.count >= 0) this.intervals[this.count] = now - this.last[0]!;
    this.count += 1;
    this.last[0] = now;
    return this.count >= SAMPLES;
  }

  /** Of the display, Hz. */
  get rate(): number {
    return rateOf(this.intervals);
  }
}
