/** Counts of a label's points: in the frame that is shown, and in the whole recording. */
import { state } from '../../store/state';
import { plural } from '../../common/format';

export interface LabelPoints {
  readonly here: number;
  readonly all: number;
}

export function pointsOf(label: number): LabelPoints {
  const here = state.timeline.value.rows.get(label)?.points[state.frame.value] ?? 0;
  return { here, all: state.counts.value.get(label) ?? 0 };
}

/** The points that lose their label when it is deleted: in this frame, and in all. */
export function lossOf(label: number): readonly [here: string, all: string] {
  const { here, all } = pointsOf(label);
  return [`${plural(here, 'point')} in this frame`, `${plural(all, 'point')} in all frames`];
}
