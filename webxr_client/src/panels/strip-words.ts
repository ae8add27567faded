/** Words for a strip of the timeline at a frame. */
import type { TimelineRow } from '../state';
import { plural } from './format';
import { cellKind, type CellKind } from './timeline-layout';

export const KIND_WORDS: Readonly<Record<CellKind, string>> = {
  none: 'not labelled',
  painted: 'painted',
  tracked: 'tracked',
  occluded: 'tracked, hidden behind something',
  doubtful: 'tracked, doubtful',
  lost: 'lost',
};

export function cellWords(row: TimelineRow | undefined, frame: number): string {
  if (!row) return KIND_WORDS.none;
  const kind = cellKind(row, frame);
  const words = [KIND_WORDS[kind]];
  const confidence = row.confidence[frame] ?? Number.NaN;
  if (kind !== 'painted' && kind !== 'none' && !Number.isNaN(confidence))
    words.push(`${Math.round(confidence * 100)} % sure`);
  const points = row.points[frame] ?? 0;
  if (points > 0) words.push(plural(points, 'point'));
  return words.join(' · ');
}
