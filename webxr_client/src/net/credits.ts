/** Room that the page has for more: credits let the server send, held back while the page lags. */
import type { Credit } from '../protocol/messages';
import type { Decoded, Pace } from './wire';

/** Segments that the page may have waiting before the server must wait too. */
const MOST_WAITING = 6;

export class Credits {
  /** Segments that the page has not taken in yet. */
  private waiting = 0;
  private pendingCredits: Credit[] = [];
  private pace: Pace = { points: null };

  /** Reset for a new connection: credits held back for the last one are void. */
  reset(): void {
    this.pendingCredits = [];
  }

  /** The decoder is done with a frame; returns the credit to send, or null while the page lags. */
  decoded({ nbytes, decodeMs }: Decoded): Credit | null {
    this.waiting += 1;
    const credit: Credit = {
      type: 'credit',
      frames: 1,
      nbytes,
      decode_ms: decodeMs,
      ...this.pace,
    };
    // A page that is busy drawing takes segments in late; the link is not to blame for that.
    if (this.waiting <= MOST_WAITING) return credit;
    this.pendingCredits.push(credit);
    return null;
  }

  /** The page took in a segment; returns a credit that was held back, or null. */
  applied(pace: Pace): Credit | null {
    this.pace = pace;
    this.waiting -= 1;
    const credit = this.pendingCredits.shift();
    return credit ? { ...credit, ...pace } : null;
  }

  /** The page's pace changed without a segment. */
  paced(pace: Pace): Credit {
    this.pace = pace;
    return { type: 'credit', frames: 0, ...pace };
  }
}
