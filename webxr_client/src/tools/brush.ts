/** Brush of a stroke: the store's settings as a message. */
import { framesAround } from '../cloud/points/accumulation';
import { actions } from '../store/actions';
import { clipBox } from './clip';
import type { Brush } from '../protocol/messages';
import { hiddenSensors } from '../store/sensors';
import { peek } from '../store/watch';
import { activeLabel, activeLabelHidden, canEdit, isStroke, notify, state } from '../store/state';
import { locallyHiddenLabels } from './seen';
import type { Way } from './ways';

/** Return the reason why painting is not possible now, and a remedy; null if it is possible. */
export function refusal(): readonly [title: string, detail: string] | null {
  const tool = peek(state.tool);
  if (peek(state.connection).state === 'refused') {
    return ['The server refused this page', 'Open the page with a valid link.'];
  }
  if (!peek(canEdit)) return ['Your role is viewer', 'Ask for an annotator’s token to paint.'];
  if (tool !== 'paint') return null;
  const label = peek(activeLabel);
  if (!label)
    return ['Choose a label first', 'Press N, or the + beside “Labels”, to make a label.'];
  if (label.locked) return ['This label is locked', 'Unlock it or choose another label.'];
  if (peek(activeLabelHidden)) return ['This label is hidden', 'Show it or choose another label.'];
  return null;
}

/** The brush of now with `radius` (metres of the recording), or null when one cannot paint. */
export function brushNow(way: Way, radius: number): Brush | null {
  const tool = peek(state.tool);
  if (!isStroke(tool) || refusal() !== null) return null;
  const { onlyUnlabeled, through, takeLabelled } = peek(state.brush);
  return {
    label: tool === 'paint' ? peek(state.activeLabel) : 0,
    tool,
    shape: way.name,
    radius,
    // For an object, "take from other labels" is the same setting.
    only_unlabeled: onlyUnlabeled && way.name !== 'object',
    through: through && way.through,
    ...(way.name === 'object' && { take_labelled: takeLabelled }),
    hidden: locallyHiddenLabels(),
    hidden_sensors: [...hiddenSensors.peek()],
    frames: framesAround(),
    clip: peek(clipBox),
  };
}

/** The brush for a stroke that begins, or null after saying why there is none. */
export function brushFor(way: Way, radius: number): Brush | null {
  const no = isStroke(peek(state.tool)) ? refusal() : null;
  if (no !== null) notify('info', ...no);
  const brush = brushNow(way, radius);
  // A stroke during playback would paint points that are no longer on screen.
  if (brush && peek(state.playing)) actions.time.pause();
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
  const tool = peek(state.tool);
  return TOOL_COLORS[tool] ?? peek(activeLabel)?.color ?? '#ffffff';
}
