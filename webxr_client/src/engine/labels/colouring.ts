/** Colours of labels: their own, or by confidence or provenance in the frame on screen. */
import { signal } from '@preact/signals';
import { hexByte, parseColor } from '../../common/colors';
import type { Label } from '../../protocol/messages';
import { state, type TimelineRow } from '../../store/state';

export const SURE = '#4cc38a';
export const UNSURE = '#ff7b72';
export const BETWEEN = '#e8b04a';
export const PAINTED = '#5ea2ff';
export const TRACKED = '#e8b04a';
/** Neither tracked nor painted here. */
export const UNKNOWN = '#8791a0';

/** Points that have another class than the one that is looked at. */
export const FADED = '#8f8f8f';

/** Tells the labels that keep their colours, while one class is looked at; null: all. */
export const looked = signal<((label: Label) => boolean) | null>(null);

/** A colour between two, "#rrggbb". */
export function mixed(from: string, to: string, share: number): string {
  const end = parseColor(to);
  const parts = parseColor(from).map((part, k) => part * (1 - share) + end[k]! * share);
  return `#${parts.map(hexByte).join('')}`;
}

/** A confidence, 0 to 1, from red over yellow to green. */
export function sureColour(sure: number): string {
  return sure < 0.5 ? mixed(UNSURE, BETWEEN, 2 * sure) : mixed(BETWEEN, SURE, 2 * sure - 1);
}

/** Confidence of tracking in a label of a frame. */
export function confidenceColour(row: TimelineRow | undefined, frame: number): string {
  const points = row?.points[frame] ?? 0;
  if (!row || points === 0) return UNKNOWN;
  const sure = row.confidence[frame] ?? NaN;
  // Points painted by a person have the greatest confidence.
  if (Number.isNaN(sure)) return (row.painted[frame] ?? 0) > 0 ? SURE : UNKNOWN;
  return sureColour(sure);
}

/** Whether a label's points in a frame were painted or tracked. */
export function provenanceColour(row: TimelineRow | undefined, frame: number): string {
  const points = row?.points[frame] ?? 0;
  if (!row || points === 0) return UNKNOWN;
  return mixed(TRACKED, PAINTED, Math.min(1, (row.painted[frame] ?? 0) / points));
}

/** The palette in the colours of now; reads signals. */
export function colouredLabels(): readonly Label[] {
  const keeps = looked.value;
  const fade = (label: Label): Label => (keeps!(label) ? label : { ...label, color: FADED });
  const labels = keeps ? state.palette.value.map(fade) : state.palette.value;
  const { color } = state.view.value;
  if (color !== 'confidence' && color !== 'provenance') return labels;
  const colour = color === 'confidence' ? confidenceColour : provenanceColour;
  const { frame } = state.shown.value;
  const { rows } = state.timeline.value;
  return labels.map((label) => ({ ...label, color: colour(rows.get(label.id), frame) }));
}
