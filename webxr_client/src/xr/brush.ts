/** What a stroke of the headset sends: the store's settings in the words of the wire. */
import { actions } from '../actions';
import type { Brush } from '../protocol/messages';
import { activeLabel, activeLabelHidden, canEdit, isStroke, notify, state } from '../state';
import { xrSettings } from './settings';

export type Way = 'ball' | 'ray' | 'fill' | 'plane' | 'lasso' | 'box';

const SHAPES = {
  ball: 'sphere',
  ray: 'ray',
  fill: 'grow',
  plane: 'plane',
  lasso: 'lasso',
  box: 'box',
} as const;

/** How the next stroke takes points. */
export function currentWay(): Way {
  const { shape } = state.brush.peek();
  return shape === 'brush' ? xrSettings.peek().tip : shape;
}

/** Why one cannot paint now, or null. */
export function refusal(): string | null {
  const tool = state.tool.peek();
  if (!canEdit.peek()) return 'You are a viewer here';
  if (tool !== 'paint') return null;
  if (!activeLabel.peek()) return 'Choose or make a label first';
  if (activeLabel.peek()?.locked) return 'This label is locked';
  return activeLabelHidden.peek() ? 'This label is hidden' : null;
}

/** The brush for a stroke with `radius` (metres of the recording), or null after saying why. */
export function brushFor(way: Way, radius: number): Brush | null {
  const tool = state.tool.peek();
  const no = refusal();
  if (no !== null) {
    notify('info', no, '');
    return null;
  }
  if (!isStroke(tool)) return null;
  const { onlyUnlabeled, through } = state.brush.peek();
  const shape = SHAPES[way];
  const label = tool === 'paint' ? state.activeLabel.peek() : 0;
  // Painting on a moving picture would paint what one no longer sees.
  if (state.playing.peek()) actions.pause();
  return {
    label,
    tool,
    shape,
    radius,
    only_unlabeled: onlyUnlabeled,
    through: through && way === 'ray',
  };
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
