/** The folding of a panel to its handle: it takes room only while it is asked for. */

/** Seconds for which a ray rests on the handle, or the eyes on one that is held, until it unfolds. */
const UNFOLD_SECONDS = 0.5;
/** Seconds for which it stays without a pointer on it; longer for transient inputs. */
const [FOLD_SECONDS, TRANSIENT_SECONDS] = [3, 8];
/** Seconds after unfolding in which nothing is pressed: the press was meant for the handle. */
const NO_PRESS_SECONDS = 0.35;

const [POINTED_AT, UNUSED, SINCE_CHANGE, FOLD_AFTER] = [0, 1, 2, 3] as const;

export class Fold {
  folded = true;
  /** It was folded on purpose: pointers on it must leave before it unfolds again. */
  private refused = false;
  private readonly seconds = Float64Array.of(0, 0, 0, FOLD_SECONDS);

  /** It has just unfolded: no press is taken yet. */
  get isJustUnfolded(): boolean {
    return !this.folded && this.seconds[SINCE_CHANGE]! < NO_PRESS_SECONDS;
  }

  set(folded: boolean): void {
    const { seconds } = this;
    this.folded = this.refused = folded;
    seconds[POINTED_AT] = seconds[UNUSED] = seconds[SINCE_CHANGE] = 0;
    seconds[FOLD_AFTER] = TRANSIENT_SECONDS;
  }

  /** Once per picture; `by` points at it, `looked`: eyes are on it. Whether it must fold or unfold now. */
  update(
    by: { readonly momentary: boolean } | null,
    looked: boolean,
    passed: Float64Array,
  ): boolean {
    const { seconds } = this;
    seconds[SINCE_CHANGE] = seconds[SINCE_CHANGE]! + passed[0]!;
    const wanted = by !== null || looked;
    if (by && !this.folded) seconds[FOLD_AFTER] = by.momentary ? TRANSIENT_SECONDS : FOLD_SECONDS;
    const runs = wanted ? POINTED_AT : UNUSED;
    seconds[runs] = seconds[runs]! + passed[0]!;
    seconds[wanted ? UNUSED : POINTED_AT] = 0;
    if (!wanted) this.refused = false;
    if (!this.folded) return seconds[UNUSED]! >= seconds[FOLD_AFTER]!;
    return !this.refused && seconds[POINTED_AT]! >= UNFOLD_SECONDS;
  }
}
