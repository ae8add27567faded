/** Cells of the timeline: states of a label in frames, and the frames to check. */
import type { TimelineRow } from './types';

export type CellKind = 'none' | 'tracked' | 'painted' | 'occluded' | 'doubtful' | 'lost';

/** Below this a tracked frame is shown as doubtful. */
const DOUBTFUL_BELOW = 0.5;

const OCCLUDED = 3;
const LOST = 4;

export function hasPoints(row: TimelineRow | undefined, frame: number): boolean {
  return (row?.points[frame] ?? 0) > 0;
}

/** State of the label's cell of a frame. */
export function cellKind(row: TimelineRow, frame: number): CellKind {
  if (row.state[frame] === LOST) return 'lost';
  if (row.state[frame] === OCCLUDED) return 'occluded';
  const painted = row.painted[frame] ?? 0;
  const points = row.points[frame] ?? 0;
  if (points === 0) return 'none';
  if (painted > 0) return 'painted';
  return (row.confidence[frame] ?? 1) < DOUBTFUL_BELOW ? 'doubtful' : 'tracked';
}

/** Return whether a person should check such a cell. */
export function wantsLook(kind: CellKind): boolean {
  return kind === 'doubtful' || kind === 'lost';
}

/** The nearest frame in a direction where no label has a point, or null. */
export function nextUnlabelled(
  rows: readonly TimelineRow[],
  from: number,
  frames: number,
  direction: 1 | -1,
): number | null {
  for (let distance = 1; distance < frames; distance++) {
    const frame = (((from + distance * direction) % frames) + frames) % frames;
    if (rows.every((row) => row.points[frame] === 0)) return frame;
  }
  return null;
}

/** Frames of any label that need a look, ascending. */
export function doubtfulFrames(rows: Iterable<TimelineRow>, frames: number): number[] {
  const doubtful = new Set<number>();
  for (const row of rows) {
    for (let frame = 0; frame < frames; frame++) {
      if (wantsLook(cellKind(row, frame))) doubtful.add(frame);
    }
  }
  return [...doubtful].sort((a, b) => a - b);
}
