/**
 * Layout of the timeline: pure functions, shared by the desk and the room.
 *
 * A `Span` is the visible stretch of frames; frame i covers [i, i + 1), so that its middle is
 * where the playhead stands.
 */
import { cellKind, type CellKind } from '../../store/cells';
import type { TimelineRow } from '../../store/state';

export interface Span {
  /** First visible frame, may be fractional while zoomed. */
  readonly first: number;
  /** Number of visible frames. */
  readonly length: number;
}

/** Kinds by severity: of kinds that share a pixel, the last one in this list is shown. */
const SEVERITY: readonly CellKind[] = [
  'none',
  'tracked',
  'painted',
  'occluded',
  'doubtful',
  'lost',
];

export interface Run {
  /** Frames [from, to), whole or grouped. */
  readonly from: number;
  readonly to: number;
  readonly kind: CellKind;
  /** Least confidence of tracked frames, in fifths: how solid they are drawn. */
  readonly sure?: number;
}

const SHADES = 5;

/** Return the confidence of tracking in frames [from, to), rounded down to a shade. */
function sureness(row: TimelineRow, from: number, to: number): number {
  let least = 1;
  for (let frame = from; frame < to; frame++) least = Math.min(least, row.confidence[frame] || 1);
  return Math.floor(least * SHADES + 1e-6) / SHADES;
}

/** Runs of equal cells in a span, frames grouped so that there are at most `columns` of them. */
export function runs(row: TimelineRow, span: Span, frames: number, columns: number): Run[] {
  const first = Math.max(0, Math.floor(span.first));
  const last = Math.min(frames, Math.ceil(span.first + span.length));
  const group = Math.max(1, Math.ceil((last - first) / Math.max(1, columns)));
  const found: Run[] = [];
  for (let at = first; at < last; at += group) {
    const to = Math.min(last, at + group);
    let worst = 0;
    for (let frame = at; frame < to; frame++) {
      worst = Math.max(worst, SEVERITY.indexOf(cellKind(row, frame)));
    }
    const kind = SEVERITY[worst]!;
    if (kind === 'none') continue;
    const shade = kind === 'tracked' ? { sure: sureness(row, at, to) } : {};
    const previous = found.at(-1);
    if (previous?.to === at && previous.kind === kind && previous.sure === shade.sure) {
      found[found.length - 1] = { ...previous, to };
    } else {
      found.push({ from: at, to, kind, ...shade });
    }
  }
  return found;
}

/** Pixels from the left edge for a (fractional) frame. */
export function frameToX(frame: number, span: Span, width: number): number {
  return ((frame - span.first) / span.length) * width;
}

/** The frame under a pixel, clamped to the recording. */
export function xToFrame(x: number, span: Span, width: number, frames: number): number {
  const frame = Math.floor(span.first + (x / Math.max(1, width)) * span.length);
  return Math.min(Math.max(0, frame), Math.max(0, frames - 1));
}

const MIN_VISIBLE = 8;

/** Zoom by `factor` (> 1 shows less) so that the frame under `x` stays under it. */
export function zoom(span: Span, factor: number, x: number, width: number, frames: number): Span {
  const length = Math.min(frames, Math.max(Math.min(MIN_VISIBLE, frames), span.length / factor));
  const anchor = span.first + (x / Math.max(1, width)) * span.length;
  return clampSpan({ first: anchor - (x / Math.max(1, width)) * length, length }, frames);
}

export function pan(span: Span, by: number, frames: number): Span {
  return clampSpan({ first: span.first + by, length: span.length }, frames);
}

export function clampSpan(span: Span, frames: number): Span {
  const length = Math.min(Math.max(1, frames), span.length);
  return { first: Math.min(Math.max(0, span.first), Math.max(0, frames - length)), length };
}

/** The span with one end, or both, moved by frames: at least as many stay as one can zoom in to. */
export function stretched(
  { first, length }: Span,
  by: number,
  end: 'first' | 'last' | 'both',
  frames: number,
): Span {
  const last = first + length;
  const least = Math.min(MIN_VISIBLE, frames);
  const from = end === 'last' ? first : end === 'first' ? first + by : first - by;
  const to = end === 'first' ? last : last + by;
  if (end === 'first') {
    const start = Math.min(Math.max(0, from), last - least);
    return { first: start, length: last - start };
  }
  const start = Math.max(0, from);
  return clampSpan({ first: start, length: Math.max(least, Math.min(frames, to) - start) }, frames);
}

/** The span moved just as far as needed to show a frame. */
export function reveal(span: Span, frame: number, frames: number): Span {
  if (frame < span.first) return clampSpan({ ...span, first: frame }, frames);
  if (frame + 1 > span.first + span.length) {
    return clampSpan({ ...span, first: frame + 1 - span.length }, frames);
  }
  return span;
}

export interface Tick {
  readonly frame: number;
  readonly major: boolean;
}

const STEPS = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 20000, 50000];
const LABEL_ROOM = 56;
const TICK_ROOM = 6;

/** Marks at the middles of shown frames: numbered ones where a number has room, small ones between. */
export function ticks(span: Span, width: number, frames: number): Tick[] {
  const perFrame = width / span.length;
  const major = STEPS.find((step) => step * perFrame >= LABEL_ROOM) ?? STEPS.at(-1)!;
  const minor = STEPS.find((step) => step * perFrame >= TICK_ROOM && major % step === 0) ?? major;
  const [from, to] = [span.first - 0.5, span.first + span.length - 0.5];
  const last = Math.min(frames - 1, Math.floor(to));
  const marks: Tick[] = [];
  for (let frame = Math.max(0, Math.ceil(from / minor) * minor); frame <= last; frame += minor) {
    marks.push({ frame, major: frame % major === 0 });
  }
  return marks;
}
