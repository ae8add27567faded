/** Counts of a label's points: in the frame that is shown, and in the whole recording. */
import { state } from '../../store/state';
import { plural } from '../../common/format';

export interface LabelPoints {
  readonly inFrame: number;
  readonly all: number;
}

export function pointsOf(label: number): LabelPoints {
  const inFrame = state.timeline.value.rows.get(label)?.points[state.frame.value] ?? 0;
  return { inFrame, all: state.counts.value.get(label) ?? 0 };
}

/** The points that lose their label when it is deleted: in this frame, and in all. */
export function lossOf(label: number): readonly [here: string, all: string] {
  const { inFrame, all } = pointsOf(label);
  return [`${plural(inFrame, 'point')} in this frame`, `${plural(all, 'point')} in all frames`];
}
