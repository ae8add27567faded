/** The keyboard, as data: the page listens by it and shows it. */
import { actions } from '../store/actions';
import { boxFromPoints, copyToFrame, interpolate, pointsFromBox } from '../boxes/changes';
import { answerDoubt, nextDoubt } from '../example/store';
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
}

/** The lasso's key, pressed again, changes how the outline is drawn. */
function chooseShape(shape: BrushShape): void {
  const again = shape === 'lasso' && state.brush.peek().shape === shape;
  if (again && isStroke(state.tool.peek())) nextOutlineKind();
  else actions.setShape(shape);
}

/** A key of the chosen box's, whichever tool is out. */
function boxed(key: string, shown: string, what: string, run: () => unknown): KeyBinding {
  return { keys: [key], shown, what, group: 'Tools', when: () => canEdit.peek(), run };
}

export const KEYS: readonly KeyBinding[] = [
  {
    keys: [' '],
    shown: 'Space',
    what: 'Play or pause',
    group: 'Time',
    run: () => actions.togglePlay(),
  },
  {
    keys: ['arrowleft'],
    shown: '←',
    what: 'One frame back',
    group: 'Time',
    repeats: true,
    run: () => actions.step(-1),
  },
  {
    keys: ['arrowright'],
    shown: '→',
    what: 'One frame forward',
    group: 'Time',
    repeats: true,
    run: () => actions.step(1),
  },
  {
    keys: ['shift+arrowleft'],
    shown: 'Shift ←',
    what: 'Ten frames back',
    group: 'Time',
    repeats: true,
    run: () => actions.step(-10),
  },
  {
    keys: ['shift+arrowright'],
    shown: 'Shift →',
    what: 'Ten frames forward',
    group: 'Time',
    repeats: true,
    run: () => actions.step(10),
  },
  { keys: ['home'], shown: 'Home', what: 'First frame', group: 'Time', run: () => actions.seek(0) },
  {
    keys: ['end'],
    shown: 'End',
    what: 'Last frame',
    group: 'Time',
    run: () => actions.seek(Number.MAX_SAFE_INTEGER),
  },
  {
    keys: [','],
    shown: ',',
    what: 'Previous doubtful frame',
    group: 'Time',
    run: () => actions.nextDoubtful(-1),
  },
  {
    keys: ['.'],
    shown: '.',
    what: 'Next doubtful frame',
    group: 'Time',
    run: () => actions.nextDoubtful(1),
  },
  { keys: ['l'], shown: 'L', what: 'Loop', group: 'Time', run: () => actions.toggleLoop() },

  {
    keys: ['v'],
    shown: 'V',
    what: 'Look around',
    group: 'Tools',
    run: () => actions.setTool('navigate'),
  },
  {
    keys: ['b'],
    shown: 'B',
    what: 'Paint',
    group: 'Tools',
    run: () => {
      actions.setTool('paint');
      actions.setShape('brush');
    },
  },
  { keys: ['c'], shown: 'C', what: 'Eraser', group: 'Tools', run: () => actions.toggleEraser() },
  ...DESK_WAYS.filter(({ shape }) => shape !== 'brush').map(({ shape, desk }): KeyBinding => ({
    keys: [desk.key.toLowerCase()],
    shown: desk.key,
    what: desk.label,
    group: 'Tools',
    run: () => chooseShape(shape),
  })),
  {
    keys: ['enter'],
    shown: 'Enter',
    what: 'Close the polygon, take the points in the box, or choose the first class',
    group: 'Tools',
    run: () => actions.closeOutline() || answerDoubt(0),
  },
  {
    keys: ['shift+enter'],
    shown: 'Shift Enter',
    what: 'Choose the second class of a doubt',
    group: 'Tools',
    run: () => answerDoubt(1),
  },
  {
    keys: [';'],
    shown: ';',
    what: 'By example: next doubt',
    group: 'Tools',
    run: () => nextDoubt(),
  },
  {
    keys: ['shift+g'],
    shown: 'Shift G',
    what: 'Snap the box to the ground',
    group: 'Tools',
    run: () => actions.snapBox(),
  },
  {
    keys: ['0'],
    shown: '0',
    what: 'Use the tool at the centre of the view',
    group: 'Tools',
    run: () => actions.useInMiddle(),
  },
  {
    keys: ['backspace'],
    shown: 'Backspace',
    what: 'Remove the polygon’s last corner',
    group: 'Tools',
    run: () => actions.takeBackCorner(),
  },
  {
    keys: ['escape'],
    shown: 'Esc',
    what: 'Cancel the stroke, lasso or object',
    listed: false,
    group: 'Tools',
    run: () => actions.cancelStroke(),
  },
  {
    keys: ['tab'],
    shown: 'Tab',
    what: 'Complete the stroke to an object, or return to the last label',
    group: 'Tools',
    run: () => actions.completeObject() || actions.lastLabel(),
  },
  {
    keys: ['+', '='],
    shown: '+',
    what: 'Object: towards the group',
    group: 'Tools',
    repeats: true,
    run: () => actions.stepObject(1),
  },
  {
    keys: ['-'],
    shown: '−',
    what: 'Object: towards the part',
    group: 'Tools',
    repeats: true,
    run: () => actions.stepObject(-1),
  },
  {
    keys: ['shift+x'],
    shown: 'Shift X',
    what: 'Restore deleted points',
    group: 'Tools',
    run: () => actions.setTool('restore'),
  },
  {
    keys: ['x'],
    shown: 'X',
    what: 'Delete noise',
    group: 'Tools',
    run: () => actions.setTool('delete'),
  },
  {
    keys: ['i'],
    shown: 'I',
    what: 'Pick a label',
    group: 'Tools',
    run: () => actions.setTool('pick'),
  },
  {
    keys: ['shift+b'],
    shown: 'Shift B',
    what: 'Boxes of objects',
    group: 'Tools',
    run: () => actions.setTool('boxes'),
  },
  boxed('shift+f', 'Shift F', 'Box from the label’s points in this frame', boxFromPoints),
  boxed('shift+p', 'Shift P', 'Points from the box in this frame', () => pointsFromBox(false)),
  boxed('shift+c', 'Shift C', 'Copy the box to the next frame', () => copyToFrame(1)),
  boxed('shift+l', 'Shift L', 'Interpolate between two drawn boxes', interpolate),
  {
    keys: ['['],
    shown: '[',
    what: 'Smaller brush',
    group: 'Tools',
    repeats: true,
    run: () => actions.nudgeRadius(-1),
  },
  {
    keys: [']'],
    shown: ']',
    what: 'Larger brush',
    group: 'Tools',
    repeats: true,
    run: () => actions.nudgeRadius(1),
  },

  {
    keys: ['1', '2', '3', '4', '5', '6', '7', '8', '9'],
    shown: '1 – 9',
    what: 'Choose a label',
    listed: false,
    group: 'Labels',
    run: (key) => actions.selectNthLabel(Number(key)),
  },
  {
    keys: [1, 2, 3, 4, 5, 6, 7, 8, 9].map((digit) => `shift+${digit}`),
    shown: 'Shift 1 – 9',
    what: 'Choose label 10, 11, …',
    listed: false,
    group: 'Labels',
    run: (key) => actions.selectNthLabel(9 + Number(key)),
  },
  {
    keys: ['/'],
    shown: '/',
    what: 'Search the labels',
    group: 'Labels',
    run: () => openSearch(),
  },
  {
    keys: ['n'],
    shown: 'N',
    what: 'New label',
    group: 'Labels',
    run: () => void actions.newLabel(),
  },

  {
    keys: ['r'],
    shown: 'R',
    what: 'Look from the sensor',
    group: 'View',
    run: () => actions.viewFrom('sensor'),
  },
  {
    keys: ['t'],
    shown: 'T',
    what: 'Look from above',
    group: 'View',
    run: () => actions.viewFrom('top'),
  },
  {
    keys: ['f'],
    shown: 'F',
    what: 'Go to the active label’s object',
    group: 'View',
    run: () => actions.goToObject(),
  },
  {
    keys: ['y'],
    shown: 'Y',
    what: 'Clip to a box or show everything',
    group: 'View',
    run: () => {
      if (clip.peek()) clip.value = null;
      else actions.clipTo(null);
    },
  },
  {
    keys: ['pageup'],
    shown: 'Page ↑',
    what: 'Move the clip box along its thinnest side',
    group: 'View',
    repeats: true,
    run: () => scrollClip(1),
  },
  {
    keys: ['pagedown'],
    shown: 'Page ↓',
    what: 'Move the clip box back',
    group: 'View',
    repeats: true,
    run: () => scrollClip(-1),
  },
  {
    keys: ['p'],
    shown: 'P',
    what: 'Perspective or orthographic',
    group: 'View',
    run: () => actions.toggleOrthographic(),
  },

  {
    keys: ['ctrl+z'],
    shown: 'Ctrl Z',
    what: 'Undo',
    group: 'Edit',
    repeats: true,
    run: () => actions.undo(),
  },
  {
    keys: ['ctrl+shift+z', 'ctrl+y'],
    shown: 'Ctrl Shift Z',
    what: 'Redo',
    group: 'Edit',
    repeats: true,
    run: () => actions.redo(),
  },
];

/** Held keys that walk (handled by the camera, listed for the help). */
export const WALK_KEYS = {
  shown: 'W A S D · E Q',
  what: 'Walk · up and down; hold Shift to run',
  group: 'View',
} as const;
