/** Answers of REST on the review, by the server's names. */

export type ReviewState = 'open' | 'review' | 'accepted' | 'rejected';
export type Place = readonly [number, number, number];

/** State of frames `first` to `last`, or (null) of a label as a whole; label null: the frames. */
export interface Standing {
  readonly first: number | null;
  readonly last: number | null;
  readonly label: number | null;
  readonly state: ReviewState;
  readonly note: string;
  readonly place: Place | null;
  readonly assignee: string;
  readonly by: string;
  /** ISO 8601. */
  readonly at: string | null;
  /** Labels changed after the state was given. */
  readonly changed: boolean;
}

export interface Overview {
  readonly counts: Readonly<Record<ReviewState, number>>;
  readonly frames: readonly Standing[];
  readonly labels: readonly Standing[];
  readonly people: readonly string[];
}

/** A suspicious thing. */
export interface Finding {
  readonly id: string;
  readonly kind: 'name' | 'few' | 'stray' | 'jump' | 'unlike';
  readonly text: string;
  readonly labels: readonly number[];
  readonly first: number | null;
  readonly last: number | null;
  readonly place: Place | null;
  readonly settled: boolean;
}

export interface Checks {
  readonly findings: readonly Finding[];
  /** Checks that were left out, in sentences. */
  readonly unchecked: readonly string[];
}

/** Values that may be set of frames, or of a label. */
export interface ReviewPatch {
  readonly first?: number;
  readonly last?: number;
  readonly label?: number;
  readonly state?: ReviewState;
  readonly note?: string;
  readonly place?: Place;
  readonly assignee?: string;
}

export interface Agreement {
  readonly miou: number | null;
  readonly same: number | null;
  readonly labels: readonly {
    readonly name: string;
    readonly iou: number;
    readonly first: number;
    readonly second: number;
  }[];
  readonly frames: readonly {
    readonly frame: number;
    readonly labelled: number;
    readonly differ: number;
  }[];
}
