/** Questions of the object tool to the server, and its offers: candidates to choose from. */
import type { CloudFrame } from '../cloud/points/frame';
import type { Brush, Sample } from '../protocol/messages';

export type Purpose = 'hover' | 'take' | 'complete';

export interface Clicks {
  readonly positives: readonly Sample[];
  readonly negatives: readonly Sample[];
}

export interface Question extends Clicks {
  readonly id: string;
  readonly frame: CloudFrame;
  readonly brush: Brush;
  readonly purpose: Purpose;
  /** Candidate that the clicks refine, or ''. */
  readonly previous: string;
  /** Points shown during the question: the most similar level is chosen; null: the server's choice. */
  readonly like: Uint32Array | null;
}

export interface Offer {
  readonly question: Question;
  readonly candidates: readonly { readonly id: string; readonly indices: Uint32Array }[];
  /** The whole frame is prepared: the next question is answered from it. */
  ready: boolean;
  level: number;
  /** A person has chosen the level. */
  chosen: boolean;
}

/** An object that was taken, and is refined by further clicks. */
export interface TakenObject extends Clicks {
  readonly frame: CloudFrame;
  /** The stroke that took it: the next one takes its place. */
  readonly edit: string;
  readonly candidate: string;
  /** Candidate that its last click refined, or '': its levels are offered again by it. */
  readonly previous: string;
  /** Tool that took it, which also refines it, independent of the current tool. */
  readonly brush: Brush;
}

/** Points of the chosen level; null: no level is offered. */
export function shownOf({ candidates, level }: Offer): Uint32Array | null {
  return candidates[level]?.indices ?? null;
}
