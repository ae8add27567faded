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
import { findPeople, peopleOffer } from '../engine/find-people';
import { clip, scrollClip } from '../tools/clip';
import { openSearch } from '../panels/labels/palette';
import { hasDepth } from '../store/sensors';
import { canEdit, isStroke, state, type BrushShape } from '../store/state';
import { nextOutlineKind } from '../tools/lasso';
import { DESK_WAYS } from '../tools/ways';

type Group = 'Time' | 'Tools' | 'Labels' | 'View' | 'Edit' | 'Work' | 'Recordings';

export interface KeyBinding {
  /** `KeyboardEvent.key` values, lower case; `ctrl+`, `shift+` and `alt+` before them. */
  readonly keys: readonly string[];
  readonly what: string;
  readonly group: Group;
  /** Keys in print, unless the first of them says it. */
  readonly shown?: string;
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

/** A command before it has a group. */
export type Ungrouped = Omit<KeyBinding, 'group'>;

/** The lasso's key, pressed again, changes how the outline is drawn. */
function chooseShape(shape: BrushShape): void {
  const isChosen = shape === 'lasso' && state.brush.peek().shape === shape;
  if (isChosen && isStroke(state.tool.peek())) nextOutlineKind();
  else actions.tools.setShape(shape);
}

/** Do the next step with found people; false when there is none. */
function takeNextStep(): boolean {
  const main = peopleOffer.peek()?.main;
  if (!main || main.disabled) return false;
  main.run();
  return true;
}

/** A command with a key, or with several. */
export function key(
  keys: string | readonly string[],
  what: string,
  run: KeyBinding['run'],
  more: Partial<Ungrouped> = {},
): Ungrouped {
  return { keys: typeof keys === 'string' ? [keys] : keys, what, run, ...more };
}

/** A command that goes on while its key is held. */
function held(keys: string | readonly string[], what: string, run: KeyBinding['run']): Ungrouped {
  return key(keys, what, run, { repeats: true });
}

/** A key of the chosen box's, whichever tool is out. */
function boxed(name: string, what: string, run: () => unknown): Ungrouped {
  return key(name, what, run, { when: () => canEdit.peek() });
}

export function inGroup(group: Group, commands: readonly Ungrouped[]): readonly KeyBinding[] {
  return commands.map((each) => ({ ...each, group }));
}

/** Left out of the command palette. */
export const UNLISTED = { listed: false } as const;

const { time, tools, labels, view, history } = actions;

const TIME = [
  key(' ', 'Play or pause', () => time.togglePlay()),
  held('arrowleft', 'One frame back', () => time.step(-1)),
  held('arrowright', 'One frame forward', () => time.step(1)),
  held('shift+arrowleft', 'Ten frames back', () => time.step(-10)),
  held('shift+arrowright', 'Ten frames forward', () => time.step(10)),
  key('home', 'First frame', () => time.seek(0)),
  key('end', 'Last frame', () => time.seek(Number.MAX_SAFE_INTEGER)),
  key(',', 'Previous doubtful frame', () => time.nextDoubtful(-1)),
  key('.', 'Next doubtful frame', () => time.nextDoubtful(1)),
  key('l', 'Loop', () => time.toggleLoop()),
];

const TOOLS = [
  key('v', 'Look around', () => tools.setTool('navigate')),
  key('b', 'Paint', () => {
    tools.setTool('paint');
    tools.setShape('brush');
  }),
  key('c', 'Eraser', () => tools.toggleEraser()),
  ...DESK_WAYS.filter(({ shape }) => shape !== 'brush').map(({ shape, desk }) =>
    key(desk.key.toLowerCase(), desk.label, () => chooseShape(shape)),
  ),
  key(
    'enter',
    'Close the polygon, take the points in the box, or answer with the likelier class',
    () => tools.closeOutline() || takeNextStep() || answerDoubt(question.peek()?.classes[0]),
  ),
  key(';', 'By example: next doubt', () => skipDoubt()),
  key('`', 'By example: natural colours while it is held', () => showNatural(true), {
    when: () => exampleOpen.peek(),
    released: () => showNatural(false),
  }),
  key('shift+g', 'Snap the box to the ground', () => tools.snapBox()),
  key(
    '0',
    'Use the tool at the centre of the view, or answer a doubt with no class',
    () => answerDoubt(null) || tools.useInMiddle(),
  ),
  key(
    'backspace',
    'Remove the polygon’s last corner, or undo the answer to a doubt',
    () => tools.takeBackCorner() || takeBackAnswer(),
  ),
  key('escape', 'Cancel the stroke, lasso or object', () => tools.cancelStroke(), UNLISTED),
  key(
    'tab',
    'Complete the stroke to an object, or return to the last label',
    () => tools.completeObject() || labels.lastLabel(),
  ),
  held(['+', '='], 'Object: larger part', () => tools.stepObject(1)),
  held('-', 'Object: smaller part', () => tools.stepObject(-1)),
  key('shift+h', 'Find people in this frame', () => findPeople(), {
    when: () => canEdit.peek() && hasDepth.peek(),
  }),
  key('shift+x', 'Restore deleted points', () => tools.setTool('restore')),
  key('x', 'Delete noise', () => tools.setTool('delete')),
  key('i', 'Pick a label', () => tools.setTool('pick')),
  key('shift+b', 'Boxes of objects', () => tools.setTool('boxes')),
  boxed('shift+f', 'Box from the label’s points in this frame', boxFromPoints),
  boxed('shift+p', 'Points from the box in this frame', () => pointsFromBox(false)),
  boxed('shift+c', 'Copy the box to the next frame', () => copyToFrame(1)),
  boxed('shift+t', 'Turn the box round: its front is at the other end', turnRound),
  boxed('shift+l', 'Interpolate between two drawn boxes', interpolate),
  held('[', 'Smaller brush', () => tools.nudgeRadius(-1)),
  held(']', 'Larger brush', () => tools.nudgeRadius(1)),
];

const DIGITS = ['1', '2', '3', '4', '5', '6', '7', '8', '9'];

const LABELS = [
  key(
    DIGITS,
    'Choose a label, or answer a doubt with a class',
    (digit) => answerNth(Number(digit)) || labels.selectNthLabel(Number(digit)),
    { shown: '1 – 9', ...UNLISTED },
  ),
  key(
    DIGITS.map((digit) => `shift+${digit}`),
    'Choose label 10, 11, …',
    (digit) => labels.selectNthLabel(9 + Number(digit)),
    { shown: 'Shift 1 – 9', ...UNLISTED },
  ),
  key('/', 'Search the labels', () => openSearch()),
  key('n', 'New label', () => void labels.newLabel()),
];

const VIEW = [
  key('r', 'Look from the sensor', () => view.viewFrom('sensor')),
  key('t', 'Look from above', () => view.viewFrom('top')),
  key('f', 'Go to the active label’s object', () => view.goToObject()),
  key('y', 'Clip to a box or show everything', () => {
    if (clip.peek()) clip.value = null;
    else view.clipTo(null);
  }),
  held('pageup', 'Move the clip box along its thinnest side', () => scrollClip(1)),
  held('pagedown', 'Move the clip box back', () => scrollClip(-1)),
  key('p', 'Perspective or orthographic', () => view.toggleOrthographic()),
];

const EDIT = [
  held('ctrl+z', 'Undo', () => history.undo()),
  held(['ctrl+shift+z', 'ctrl+y'], 'Redo', () => history.redo()),
];

export const KEYS: readonly KeyBinding[] = [
  ...inGroup('Time', TIME),
  ...inGroup('Tools', TOOLS),
  ...inGroup('Labels', LABELS),
  ...inGroup('View', VIEW),
  ...inGroup('Edit', EDIT),
];

/** Held keys that walk (handled by the camera, listed for the help). */
export const WALK_KEYS = {
  shown: 'W A S D · E Q',
  what: 'Walk · up and down; hold Shift to run',
  group: 'View',
} as const;
