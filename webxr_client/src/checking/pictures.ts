/** Times between pictures while the recording plays. */
import type { HeadsetPictures } from '../protocol/values';
import { rateOf } from '../xr/refresh';

/** Pictures that are timed. */
export const ENOUGH = 120;
/** A picture is late from this many refreshes on. */
const LATE = 1.5;

export class Pictures {
  private readonly intervals = new Float64Array(ENOUGH);
  private count = 0;
  private last = NaN;

  /** Take in the time of a picture, milliseconds; `counts`: the recording plays. */
  note(now: number, counts: boolean): void {
    const interval = now - this.last;
    this.last = counts ? now : NaN;
    if (counts && interval > 0 && !this.enough) this.intervals[this.count++] = interval;
  }

  get enough(): boolean {
    return this.count === ENOUGH;
  }

  /** Sum the times up; null before there are any. */
  sum(session: XRSession): HeadsetPictures | null {
    const { count } = this;
    if (count === 0) return null;
    const sorted = this.intervals.slice(0, count).sort();
    const found = rateOf(sorted);
    const reportedRate = session.frameRate ?? null;
    const late = (LATE * 1000) / (reportedRate ?? found);
    return {
      told: reportedRate,
      offered: [...(session.supportedFrameRates ?? [])],
      found,
      count,
      median_ms: rounded(sorted[count >> 1]!),
      p95_ms: rounded(sorted[Math.floor(0.95 * count)]!),
      late: sorted.filter((interval) => interval > late).length,
    };
  }
}

function rounded(milliseconds: number): number {
  return Math.round(100 * milliseconds) / 100;
}
