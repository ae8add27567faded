/** Keys that move, turn and size the chosen box while its tool is out. */
import { chosenBox } from '../store/boxes';
import { canEdit, state } from '../store/state';
import { commitDraft, dragTo, removeBox, changeBox, shownIn } from './changes';
import { moved, stretched, turned, type Axis, type Shape } from './shape';

/** Metres and radians of a press, and with Shift. */
const STEP = 0.02;
const COARSE = 10;
const TURN = Math.PI / 180;
const COARSE_TURN = 5;
/** Presses that come so soon after one another are one edit, milliseconds. */
const REST_MS = 600;

/** Axis and direction along it: forward, left, up. */
const MOVES: Readonly<Record<string, readonly [Axis, 1 | -1]>> = {
  w: [0, 1],
  s: [0, -1],
  a: [1, 1],
  d: [1, -1],
  pageup: [2, 1],
  pagedown: [2, -1],
};
const TURNS: Readonly<Record<string, 1 | -1>> = { q: 1, e: -1 };

/** For the help. */
export const BOX_KEYS = [
  ['W A S D', 'Move the box'],
  ['Q E', 'Turn the box'],
  ['Page ↑ ↓', 'Lift and lower the box'],
  ['Alt W S', 'Longer and shorter, at the front'],
  ['Alt A D', 'Wider and narrower, to both sides'],
  ['Alt Page ↑ ↓', 'Higher and lower, at the top'],
  ['Shift', 'With these keys: larger steps'],
  ['Delete', 'Remove the box from this frame'],
  ['Shift Delete', 'Delete the box'],
].map(([shown, what]) => ({ shown: shown!, what: what!, group: 'Boxes' }));

let timer: ReturnType<typeof setTimeout> | undefined;

function nudged(shape: Shape, key: string, size: boolean, coarse: boolean): Shape | null {
  const turn = TURNS[key];
  if (turn !== undefined && !size)
    return turned(shape, 2, turn * TURN * (coarse ? COARSE_TURN : 1));
  const move = MOVES[key];
  if (!move) return null;
  const [axis, way] = move;
  const by: [number, number, number] = [0, 0, 0];
  by[axis] = way * STEP * (coarse ? COARSE : 1);
  if (!size) return moved(shape, by);
  if (axis !== 1) return stretched(shape, [axis === 0 ? 1 : 0, 0, axis === 2 ? 1 : 0], by);
  const half = by[1] / 2;
  return stretched(stretched(shape, [0, 1, 0], [0, half, 0]), [0, -1, 0], [0, -half, 0]);
}

/** Change the chosen box by a key; false: it is not one of these, or there is no box. */
export function boxKey({ key, altKey, shiftKey, ctrlKey, metaKey }: KeyboardEvent): boolean {
  if (state.tool.peek() !== 'boxes' || !canEdit.peek() || ctrlKey || metaKey) return false;
  const box = chosenBox.peek();
  const { frame } = state.shown.peek();
  const shape = box && shownIn(box, frame);
  if (!shape) return false;
  if (key === 'Delete') {
    void (shiftKey ? removeBox(box) : changeBox(box.id, { poses: { [frame]: null } }));
    return true;
  }
  const next = nudged(shape, key.toLowerCase(), altKey, shiftKey);
  if (!next) return false;
  dragTo(box, frame, next);
  clearTimeout(timer);
  timer = setTimeout(commitDraft, REST_MS);
  return true;
}
