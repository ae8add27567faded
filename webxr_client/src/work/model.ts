/** Values of the review: the server's answers by its names, their order, and their texts. */
import type { Agreement, Finding, ReviewOverview, ReviewPatch, Standing } from '../protocol/values';

export type ReviewState = Standing['state'];
export type Place = readonly [number, number, number];

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
export function standingOf(overview: ReviewOverview | null, frame: number): Standing | null {
  const covers = ({ first, last, label }: Standing): boolean =>
    label === null && first !== null && last !== null && first <= frame && frame <= last;
  return overview?.frames.find(covers) ?? null;
}

/** Return the frames and labels with a note, including labels in frames. */
export function notesOf(overview: ReviewOverview | null): readonly Standing[] {
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
