/** The keyboard, as data: the page listens by it and shows it. */
import { actions } from '../store/actions';
import {
  boxFromPoints,
  copyToFrame,
  interpolate,
  pointsFromBox,
  turnRound,
} from '../boxes/changes';
import { answerDoubt, answerNth, exampleOpen, question, showNatural, skipDoubt, takeBackAnswer } from '../example/store'; // prettier-ignore
import { clip, scrollClip } from '../tools/clip';
import { openSearch } from '../panels/labels/palette';
import { canEdit, isStroke, state, type BrushShape } from '../store/state';
import { nextOutlineKind } from '../tools/lasso';
import { DESK_WAYS } from '../tools/ways';

export interface KeyBinding {
  /** `KeyboardEvent.key` values, lower case; `ctrl+`, `shift+` and `alt+` before them. */
  readonly keys: readonly string[];
  /** Name in print, e.g. "Space". */
  readonly shown: string;
  readonly what: string;
  readonly group: 'Time' | 'Tools' | 'Labels' | 'View' | 'Edit' | 'Work' | 'Recordings';
  /** Also when the key is held. */
  readonly repeats?: boolean;
  /** Whether it makes sense now; without it: whenever a recording is open. */
  readonly when?: () => boolean;
  /** False: the command palette does not offer it. */
  readonly listed?: false;
  /** False: there was nothing to do, and the key is the browser's. */
  readonly run: (key: string) => unknown;
  /** The key is no longer held. */
  readonly released?: () => void;
}

/** The lasso's key, pressed again, changes how the outline is drawn. */
function chooseShape(shape: BrushShape): void {
  const isChosen = shape === 'lasso' && state.brush.peek().shape === shape;
  if (isChosen && isStroke(state.tool.peek())) nextOutlineKind();
  else actions.tools.setShape(shape);
}

const HELD = { repeats: true } as const;

/** A command with a key, or with several. */
export function key(
  keys: string | readonly string[],
  shown: string,
  group: KeyBinding['group'],
  what: string,
  run: KeyBinding['run'],
  more: Partial<KeyBinding> = {},
): KeyBinding {
  return { keys: typeof keys === 'string' ? [keys] : keys, shown, group, what, run, ...more };
}

/** A key of the chosen box's, whichever tool is out. */
function boxed(name: string, shown: string, what: string, run: () => unknown): KeyBinding {
  return key(name, shown, 'Tools', what, run, { when: () => canEdit.peek() });
}

export const KEYS: readonly KeyBinding[] = [
  key(' ', 'Space', 'Time', 'Play or pause', () => actions.time.togglePlay()),
  key('arrowleft', '←', 'Time', 'One frame back', () => actions.time.step(-1), HELD),
  key('arrowright', '→', 'Time', 'One frame forward', () => actions.time.step(1), HELD),
  key('shift+arrowleft', 'Shift ←', 'Time', 'Ten frames back', () => actions.time.step(-10), HELD),
  key(
    'shift+arrowright',
    'Shift →',
    'Time',
    'Ten frames forward',
    () => actions.time.step(10),
    HELD,
  ),
  key('home', 'Home', 'Time', 'First frame', () => actions.time.seek(0)),
  key('end', 'End', 'Time', 'Last frame', () => actions.time.seek(Number.MAX_SAFE_INTEGER)),
  key(',', ',', 'Time', 'Previous doubtful frame', () => actions.time.nextDoubtful(-1)),
  key('.', '.', 'Time', 'Next doubtful frame', () => actions.time.nextDoubtful(1)),
  key('l', 'L', 'Time', 'Loop', () => actions.time.toggleLoop()),

  key('v', 'V', 'Tools', 'Look around', () => actions.tools.setTool('navigate')),
  key('b', 'B', 'Tools', 'Paint', () => {
    actions.tools.setTool('paint');
    actions.tools.setShape('brush');
  }),
  key('c', 'C', 'Tools', 'Eraser', () => actions.tools.toggleEraser()),
  ...DESK_WAYS.filter(({ shape }) => shape !== 'brush').map(({ shape, desk }): KeyBinding => ({
    keys: [desk.key.toLowerCase()],
    shown: desk.key,
    what: desk.label,
    group: 'Tools',
    run: () => chooseShape(shape),
  })),
  key(
    'enter',
    'Enter',
    'Tools',
    'Close the polygon, take the points in the box, or answer with the likelier class',
    () => actions.tools.closeOutline() || answerDoubt(question.peek()?.classes[0]),
  ),
  key(';', ';', 'Tools', 'By example: next doubt', () => skipDoubt()),
  key('`', '`', 'Tools', 'By example: natural colours while it is held', () => showNatural(true), {
    when: () => exampleOpen.peek(),
    released: () => showNatural(false),
  }),
  key('shift+g', 'Shift G', 'Tools', 'Snap the box to the ground', () => actions.tools.snapBox()),
  key(
    '0',
    '0',
    'Tools',
    'Use the tool at the centre of the view, or answer a doubt with no class',
    () => answerDoubt(null) || actions.tools.useInMiddle(),
  ),
  key(
    'backspace',
    'Backspace',
    'Tools',
    'Remove the polygon’s last corner, or undo the answer to a doubt',
    () => actions.tools.takeBackCorner() || takeBackAnswer(),
  ),
  {
    keys: ['escape'],
    shown: 'Esc',
    what: 'Cancel the stroke, lasso or object',
    listed: false,
    group: 'Tools',
    run: () => actions.tools.cancelStroke(),
  },
  key(
    'tab',
    'Tab',
    'Tools',
    'Complete the stroke to an object, or return to the last label',
    () => actions.tools.completeObject() || actions.labels.lastLabel(),
  ),
  key(
    ['+', '='],
    '+',
    'Tools',
    'Object: towards the group',
    () => actions.tools.stepObject(1),
    HELD,
  ),
  key('-', '−', 'Tools', 'Object: towards the part', () => actions.tools.stepObject(-1), HELD),
  key('shift+x', 'Shift X', 'Tools', 'Restore deleted points', () =>
    actions.tools.setTool('restore'),
  ),
  key('x', 'X', 'Tools', 'Delete noise', () => actions.tools.setTool('delete')),
  key('i', 'I', 'Tools', 'Pick a label', () => actions.tools.setTool('pick')),
  key('shift+b', 'Shift B', 'Tools', 'Boxes of objects', () => actions.tools.setTool('boxes')),
  boxed('shift+f', 'Shift F', 'Box from the label’s points in this frame', boxFromPoints),
  boxed('shift+p', 'Shift P', 'Points from the box in this frame', () => pointsFromBox(false)),
  boxed('shift+c', 'Shift C', 'Copy the box to the next frame', () => copyToFrame(1)),
  boxed('shift+t', 'Shift T', 'Turn the box round: its front is at the other end', turnRound),
  boxed('shift+l', 'Shift L', 'Interpolate between two drawn boxes', interpolate),
  key('[', '[', 'Tools', 'Smaller brush', () => actions.tools.nudgeRadius(-1), HELD),
  {
    keys: [']'],
    shown: ']',
    what: 'Larger brush',
    group: 'Tools',
    repeats: true,
    run: () => actions.tools.nudgeRadius(1),
  },

  {
    keys: ['1', '2', '3', '4', '5', '6', '7', '8', '9'],
    shown: '1 – 9',
    what: 'Choose a label, or answer a doubt with a class',
    listed: false,
    group: 'Labels',
    run: (key) => answerNth(Number(key)) || actions.labels.selectNthLabel(Number(key)),
  },
  {
    keys: [1, 2, 3, 4, 5, 6, 7, 8, 9].map((digit) => `shift+${digit}`),
    shown: 'Shift 1 – 9',
    what: 'Choose label 10, 11, …',
    listed: false,
    group: 'Labels',
    run: (key) => actions.labels.selectNthLabel(9 + Number(key)),
  },
  key('/', '/', 'Labels', 'Search the labels', () => openSearch()),
  key('n', 'N', 'Labels', 'New label', () => void actions.labels.newLabel()),

  key('r', 'R', 'View', 'Look from the sensor', () => actions.view.viewFrom('sensor')),
  key('t', 'T', 'View', 'Look from above', () => actions.view.viewFrom('top')),
  key('f', 'F', 'View', 'Go to the active label’s object', () => actions.view.goToObject()),
  key('y', 'Y', 'View', 'Clip to a box or show everything', () => {
    if (clip.peek()) clip.value = null;
    else actions.view.clipTo(null);
  }),
  key(
    'pageup',
    'Page ↑',
    'View',
    'Move the clip box along its thinnest side',
    () => scrollClip(1),
    HELD,
  ),
  key('pagedown', 'Page ↓', 'View', 'Move the clip box back', () => scrollClip(-1), HELD),
  key('p', 'P', 'View', 'Perspective or orthographic', () => actions.view.toggleOrthographic()),

  key('ctrl+z', 'Ctrl Z', 'Edit', 'Undo', () => actions.history.undo(), HELD),
  key(
    ['ctrl+shift+z', 'ctrl+y'],
    'Ctrl Shift Z',
    'Edit',
    'Redo',
    () => actions.history.redo(),
    HELD,
  ),
];

/** Held keys that walk (handled by the camera, listed for the help). */
export const WALK_KEYS = {
  shown: 'W A S D · E Q',
  what: 'Walk · up and down; hold Shift to run',
  group: 'View',
} as const;
