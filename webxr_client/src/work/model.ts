/** Values of the review: the server's answers by its names, their order, and their texts. */

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
}

/** A suspicious thing. */
export interface Finding {
  readonly id: string;
  readonly kind:
    | 'name'
    | 'category'
    | 'few'
    | 'stray'
    | 'jump'
    | 'unlike'
    | 'predicted'
    | 'returned'
    | 'box_jump'
    | 'box_size'
    | 'box_overlap'
    | 'box_ground'
    | 'box_empty'
    | 'box_outside'
    | 'box_heading';
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

/** Order of findings, and texts of the review, without requests. */
export const STATES: readonly ReviewState[] = ['open', 'review', 'accepted', 'rejected'];
export const STATE_WORDS: Readonly<Record<ReviewState, string>> = {
  open: 'open',
  review: 'to check',
  accepted: 'checked',
  rejected: 'to correct',
};

/** Return the unsettled findings. */
export function unsettled(findings: readonly Finding[]): readonly Finding[] {
  return findings.filter((finding) => !finding.settled);
}

/**
 * The finding after (1) or before (−1) the one of an id, round the end.  Without one, or when it
 * has gone, the nearest at or beyond the frame; null when there are none.
 */
export function stepFrom(
  findings: readonly Finding[],
  current: string | null,
  frame: number,
  direction: 1 | -1,
): Finding | null {
  const { length } = findings;
  if (length === 0) return null;
  const at = findings.findIndex(({ id }) => id === current);
  if (at >= 0) return findings[(at + direction + length) % length]!;
  const order = direction === 1 ? findings : [...findings].reverse();
  const beyond = ({ first }: Finding): boolean =>
    first !== null && (direction === 1 ? first >= frame : first <= frame);
  return order.find(beyond) ?? order[0]!;
}

/** Return the text of the frames of a finding or a standing. */
export function framesOf({ first, last }: Pick<Standing, 'first' | 'last'>): string {
  if (first === null || last === null) return 'palette';
  return first === last ? `frame ${first}` : `frames ${first}–${last}`;
}

/** Return the state of a frame itself. */
export function standingOf(overview: Overview | null, frame: number): Standing | null {
  const covers = ({ first, last, label }: Standing): boolean =>
    label === null && first !== null && last !== null && first <= frame && frame <= last;
  return overview?.frames.find(covers) ?? null;
}

/** Return the frames and labels with a note, including labels in frames. */
export function notesOf(overview: Overview | null): readonly Standing[] {
  return [...(overview?.frames ?? []), ...(overview?.labels ?? [])].filter(({ note }) => note);
}

/** Return the decisions that accept a finding: each of its labels in its frames, or the frames. */
export function acceptances({ labels, first, last }: Finding): readonly ReviewPatch[] {
  const frames = first === null || last === null ? {} : { first, last };
  const parts = labels.map((label) => ({ ...frames, label, state: 'accepted' as const }));
  return parts.length > 0 ? parts : [{ ...frames, state: 'accepted' }];
}

/** Return the frames with the greatest difference, as a share of points that either labelled. */
export function worstFrames({ frames }: Agreement, most = 6): Agreement['frames'] {
  const share = (each: Agreement['frames'][number]): number => each.differ / each.labelled;
  return frames
    .filter(({ differ }) => differ > 0)
    .sort((a, b) => share(b) - share(a))
    .slice(0, most);
}

/** 0.5 → "50 %"; of nothing there is no share. */
export function percent(share: number | null): string {
  return share === null ? '–' : `${(100 * share).toFixed(share > 0.995 && share < 1 ? 1 : 0)} %`;
}
