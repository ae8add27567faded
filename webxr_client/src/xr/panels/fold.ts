/** The folding of a panel to its handle: it takes room only while it is asked for. */

/** Seconds for which a ray rests on the handle, or the eyes on one that is held, until it unfolds. */
const RESTS = 0.5;
/** Seconds for which it stays without a pointer on it; longer for transient inputs. */
const [STAYS, STAYS_FOR_PRESSES] = [3, 8];
/** Seconds after unfolding in which nothing is pressed: the press was meant for the handle. */
const YOUNG = 0.35;

const [RESTED, ALONE, SINCE, STAY] = [0, 1, 2, 3] as const;

export class Fold {
  folded = true;
  /** It was folded on purpose: pointers on it must leave before it unfolds again. */
  private refused = false;
  private readonly seconds = Float64Array.of(0, 0, 0, STAYS);

  /** It has just unfolded: no press is taken yet. */
  get young(): boolean {
    return !this.folded && this.seconds[SINCE]! < YOUNG;
  }

  set(folded: boolean): void {
    const { seconds } = this;
    this.folded = this.refused = folded;
    seconds[RESTED] = seconds[ALONE] = seconds[SINCE] = 0;
    seconds[STAY] = STAYS_FOR_PRESSES;
  }

  /** Once per picture; `by` points at it, `looked`: eyes are on it. Whether it must fold or unfold now. */
  update(
    by: { readonly momentary: boolean } | null,
    looked: boolean,
    passed: Float64Array,
  ): boolean {
    const { seconds } = this;
    seconds[SINCE] = seconds[SINCE]! + passed[0]!;
    const wanted = by !== null || looked;
    if (by && !this.folded) seconds[STAY] = by.momentary ? STAYS_FOR_PRESSES : STAYS;
    const runs = wanted ? RESTED : ALONE;
    seconds[runs] = seconds[runs]! + passed[0]!;
    seconds[wanted ? ALONE : RESTED] = 0;
    if (!wanted) this.refused = false;
    if (!this.folded) return seconds[ALONE]! >= seconds[STAY]!;
    return !this.refused && seconds[RESTED]! >= RESTS;
  }
}
