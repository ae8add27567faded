/** Brush of a stroke: the store's settings in the words of the wire. */
import { framesAround } from '../accumulation';
import { actions } from '../actions';
import { clipBox } from '../clip';
import type { Brush } from '../protocol/messages';
import { activeLabel, activeLabelHidden, canEdit, isStroke, notify, state } from '../state';
import { hiddenHere } from './seen';
import type { Way } from './ways';

/** Return the reason that one cannot paint now, and what to do about it; null when one can. */
export function refusal(): readonly [title: string, detail: string] | null {
  const tool = state.tool.peek();
  if (state.connection.peek().state === 'refused') {
    return ['The server refused this page', 'Open it again by a link that is valid.'];
  }
  if (!canEdit.peek()) return ['You are a viewer here', 'Ask for an annotator’s token to paint.'];
  if (tool !== 'paint') return null;
  const label = activeLabel.peek();
  if (!label) return ['Choose a label first', 'Make one with the + beside “Labels”, or press N.'];
  if (label.locked) return ['This label is locked', 'Unlock it, or choose another one.'];
  if (activeLabelHidden.peek()) return ['This label is hidden', 'Show it, or choose another one.'];
  return null;
}

/** The brush of now with `radius` (metres of the recording), or null when one cannot paint. */
export function brushNow(way: Way, radius: number): Brush | null {
  const tool = state.tool.peek();
  if (!isStroke(tool) || refusal() !== null) return null;
  const { onlyUnlabeled, through, takeLabelled } = state.brush.peek();
  return {
    label: tool === 'paint' ? state.activeLabel.peek() : 0,
    tool,
    shape: way.wire,
    radius,
    // Of an object, "take from other labels" says the same.
    only_unlabeled: onlyUnlabeled && way.name !== 'object',
    through: through && way.through,
    ...(way.name === 'object' && { take_labelled: takeLabelled }),
    hidden: hiddenHere(),
    frames: framesAround(),
    clip: clipBox.peek(),
  };
}

/** The brush for a stroke that begins, or null after saying why there is none. */
export function brushFor(way: Way, radius: number): Brush | null {
  const no = isStroke(state.tool.peek()) ? refusal() : null;
  if (no !== null) notify('info', ...no);
  const brush = brushNow(way, radius);
  // Painting on a moving picture would paint what one no longer sees.
  if (brush && state.playing.peek()) actions.pause();
  return brush;
}

const TOOL_COLORS: Record<string, string> = {
  erase: '#e8edf2',
  delete: '#ff5d5d',
  restore: '#7ddc8f',
  pick: '#ffffff',
  floor: '#8bbcff',
};

/** The colour that the brush is shown in. */
export function brushColor(): string {
  const tool = state.tool.peek();
  return TOOL_COLORS[tool] ?? activeLabel.peek()?.color ?? '#ffffff';
}
