/** Actions of tools and of the brush. */
import type { ActionParts } from '../store/actions';
import { offers } from '../store/limits';
import { isStroke, patch, RADIUS_MAX, RADIUS_MIN, state, type Tool } from '../store/state';

const RADIUS_NOTCH = 1.15;
/** Tool that follows the eraser when it is put down. */
let painter: Tool = 'paint';

export function setRadius(metres: number): void {
  patch(state.brush, { radius: Math.min(RADIUS_MAX, Math.max(RADIUS_MIN, metres)) });
}

function toggleEraser(): void {
  const tool = state.tool.peek();
  if (tool === 'erase') {
    state.tool.value = painter;
    return;
  }
  if (!offers('erase')) return;
  painter = isStroke(tool) ? tool : 'paint';
  state.tool.value = 'erase';
}

export const brushActions = {
  tools: {
    setTool: (tool) => {
      if (offers(tool)) state.tool.value = tool;
    },
    setShape: (shape) => {
      if (!offers(shape)) return;
      patch(state.brush, { shape });
      if (!isStroke(state.tool.peek())) state.tool.value = 'paint';
    },
    setRadius,
    nudgeRadius: (notches) => setRadius(state.brush.peek().radius * RADIUS_NOTCH ** notches),
    toggleEraser,
  },
  view: {
    setView: (settings) => patch(state.view, settings),
  },
} satisfies ActionParts;
