/**
 * All commands in one table: the keyboard uses it, the help lists its
 * shortcuts, and the command palette offers all of it.
 */
import { actions, type ViewPreset } from '../store/actions';
import { toggleExample } from '../example/store';
import { signOut } from '../engine/people/sign-out';
import { exportOpen } from '../panels/export-menu';
import { historyOpen } from '../panels/history-menu';
import { commandsOpen, helpOpen } from '../panels/parts/popover';
import { pickFiles } from '../panels/importing/files';
import { frameRange } from '../store/range';
import { renaming } from '../store/palette-list';
import { beginTour } from '../panels/tour-steps';
import { trackOpen } from '../panels/timeline/track-form';
import {
  activeLabel,
  canEdit,
  canManage,
  canReview,
  patch,
  state,
  trackingJob,
  type BrushSettings,
  type ColorMode,
  type Tool,
  type ViewSettings,
} from '../store/state';
import { accumulation } from '../cloud/points/accumulation';
import { chooseTheme, theme } from '../store/theme';
import { clip } from '../tools/clip';
import { outlineKind, type OutlineKind } from '../tools/lasso';
import { NOTE } from '../work/parts';
import { accept, judged, nextReview, nextTask } from '../work/queue';
import { reviewFrame, stepFindings } from '../work/review';
import { openWork } from '../work/store';
import { key, KEYS, type KeyBinding } from './keys';

type Group = KeyBinding['group'];

const inRecording = (): boolean => state.sequence.peek() !== null;
const edits = (): boolean => inRecording() && canEdit.peek();
const hasLabel = (): boolean => edits() && activeLabel.peek() !== null;

const reviews = (): boolean => inRecording() && canReview.peek();
const judges = (): boolean => inRecording() && judged.peek() !== null;

const WORK = [
  ['tasks', 'Tasks of the project'],
  ['findings', 'Suspicious places'],
  ['frames', 'States and notes of frames'],
  ['agreement', 'Agreement of annotators: compare, majority, ground truth'],
  ['versions', 'Versions of the labels'],
] as const;

/** Open the form for the note of the task to review. */
function writeNote(): void {
  openWork('tasks');
  requestAnimationFrame(() => document.getElementById(NOTE)?.focus());
}

/** A command that has no shortcut. */
function plain(
  group: Group,
  what: string,
  run: () => unknown,
  when: () => boolean = inRecording,
): KeyBinding {
  return key([], '', group, what, run, { when });
}

function tool(name: Tool, what: string): KeyBinding {
  return plain('Tools', what, () => actions.tools.setTool(name), edits);
}

function outline(kind: OutlineKind, what: string): KeyBinding {
  return plain(
    'Tools',
    what,
    () => {
      actions.tools.setShape('lasso');
      outlineKind.value = kind;
    },
    edits,
  );
}

type Switches<T> = { [K in keyof T]: T[K] extends boolean ? K : never }[keyof T];

function brushSwitch(name: Switches<BrushSettings>, what: string): KeyBinding {
  return plain(
    'Tools',
    `${what}: on or off`,
    () => patch(state.brush, { [name]: !state.brush.peek()[name] }),
    edits,
  );
}

function viewSwitch(name: Switches<ViewSettings>, what: string): KeyBinding {
  return plain('View', `${what}: show or hide`, () =>
    actions.view.setView({ [name]: !state.view.peek()[name] }),
  );
}

function from(preset: ViewPreset, what: string): KeyBinding {
  return plain('View', what, () => actions.view.viewFrom(preset));
}

function colour(color: ColorMode, what: string, field = ''): KeyBinding {
  return plain(
    'View',
    `Colour points by ${what}`,
    () => actions.view.setView({ color }),
    () => inRecording() && (!field || (state.sequence.peek()?.fields ?? []).includes(field)),
  );
}

function label(what: string, run: (id: number) => unknown): KeyBinding {
  return plain('Labels', what, () => run(state.activeLabel.peek()), hasLabel);
}

const MORE: readonly KeyBinding[] = [
  {
    keys: ['ctrl+k'],
    shown: 'Ctrl K',
    group: 'Edit',
    what: 'All commands',
    listed: false,
    run: () => (commandsOpen.value = true),
  },
  {
    keys: ['?'],
    shown: '?',
    group: 'View',
    what: 'Keyboard and mouse',
    when: () => true,
    run: () => (helpOpen.value = true),
  },
  plain('View', 'First steps: a tour of five cards', beginTour),
  plain(
    'View',
    'Light or dark theme',
    () => chooseTheme(theme.peek() === 'light' ? 'dark' : 'light'),
    () => true,
  ),
  key('z', 'Z', 'Work', 'Next suspicious place', () => stepFindings(1)),
  key('shift+z', 'Shift Z', 'Work', 'Previous suspicious place', () => stepFindings(-1)),
  key('shift+y', 'Shift Y', 'Work', 'Confirm the doubtful labels of this frame', () => {
    if (canReview.peek()) void actions.tracking.acceptFrame();
  }),
  key('ctrl+enter', 'Ctrl Enter', 'Work', 'Mark this frame as checked', () =>
    reviewFrame('accepted'),
  ),
  key('ctrl+backspace', 'Ctrl Backspace', 'Work', 'Mark this frame as to be corrected', () =>
    reviewFrame('rejected'),
  ),
  key('shift+n', 'Shift N', 'Work', 'Hand in my task and open the next', () => nextTask()),
  plain('Work', 'Review the next task', nextReview, reviews),
  plain('Work', 'Accept the task', () => accept(judged.peek()!), judges),
  plain('Work', 'Return the task with a note…', writeNote, judges),
  ...WORK.map(([tab, what]) =>
    plain('Work', what, () => openWork(tab), tab === 'agreement' ? reviews : inRecording),
  ),
  key('u', 'U', 'Time', 'Next frame without labels', () => actions.time.nextUnlabelled(1)),
  key('shift+u', 'Shift U', 'Time', 'Previous frame without labels', () =>
    actions.time.nextUnlabelled(-1),
  ),
  key('shift+i', 'Shift I', 'Time', 'In point: the loop begins here', () => actions.time.setIn()),
  key('shift+o', 'Shift O', 'Time', 'Out point: the loop ends here', () => actions.time.setOut()),
  plain('Time', 'Clear in and out points', () => (frameRange.value = null)),
  ...[0.1, 0.25, 0.5, 1, 2, 4].map((speed) =>
    plain('Time', `Play at ${speed}×`, () => actions.time.setSpeed(speed)),
  ),
  tool('paint', 'Paint with the last shape'),
  outline('polygon', 'Polygon: click the corners of an outline'),
  outline('rectangle', 'Rectangle: drag an outline from corner to corner'),
  tool('floor', 'Set the floor'),
  plain('Tools', 'Reset the floor to the import', () => actions.view.resetFloor(), edits),
  brushSwitch('onlyUnlabeled', 'Only unlabeled points'),
  brushSwitch('through', 'Points behind the first surface'),
  brushSwitch('takeLabelled', 'Take objects from other labels'),
  brushSwitch('complete', 'Offer objects after a stroke'),
  brushSwitch('follow', 'Follow painted labels'),
  label('Rename the label', (id) => (renaming.value = id)),
  label('Hide or show the label', (id) => actions.labels.toggleVisible(id)),
  label('Lock or unlock the label', (id) => actions.labels.toggleLock(id)),
  label('Show only the label, or all', (id) => actions.labels.solo(id)),
  label('Split the label into parts', (id) => actions.labels.splitLabel(id)),
  label('Delete the label', (id) => actions.labels.deleteLabel(id)),
  plain('Labels', 'Add the labels of a palette file…', () => actions.labels.pickPalette(), edits),
  plain('Labels', 'Save the palette as a file', () => actions.labels.savePalette()),
  viewSwitch('hideUnlabeled', 'Only labeled points'),
  viewSwitch('boxes', 'Boxes'),
  viewSwitch('trails', 'Trails'),
  viewSwitch('ghost', 'Ghost of the previous frame'),
  viewSwitch('eyeDome', 'Depth shading'),
  viewSwitch('grid', 'Grid'),
  viewSwitch('showDeleted', 'Deleted points'),
  colour('rgb', 'source colour', 'rgb'),
  colour('intensity', 'intensity', 'intensity'),
  colour('height', 'height'),
  colour('distance', 'distance'),
  colour('normal', 'surface direction'),
  colour('plain', 'one colour'),
  colour('provenance', 'how they were labelled'),
  plain('View', 'Neighbouring frames: overlay or not', () =>
    patch(accumulation, { on: !accumulation.peek().on }),
  ),
  plain('View', 'Clip box follows the active object: on or off', () => {
    const now = clip.peek();
    if (now) clip.value = { ...now, follows: !now.follows };
  }),
  plain('View', 'Clip to a level slab', () => actions.view.clipTo(1)),
  plain('View', 'Clip to a slab across the view', () => actions.view.clipTo(2)),
  plain('View', 'Clip to a slab along the view', () => actions.view.clipTo(0)),
  from('front', 'Look from the front'),
  from('left', 'Look from the left'),
  from('right', 'Look from the right'),
  from('fit', 'Show everything'),
  plain(
    'Edit',
    'Track labels…',
    () => (trackOpen.value = true),
    () => edits() && trackingJob.peek() === null,
  ),
  plain('Edit', 'Label by example: show or hide the prediction', () => toggleExample()),
  plain('Edit', 'Track on from this frame', () => actions.tracking.continueRun(), edits),
  plain('Edit', 'History of edits', () => (historyOpen.value = true)),
  plain('Recordings', 'Export points and labels…', () => (exportOpen.value = true)),
  plain('Recordings', 'All recordings', () => actions.recordings.closeSequence()),
  plain('Recordings', 'Sign out', signOut, () => state.me.peek() !== null),
  plain(
    'Recordings',
    'Import files…',
    () => pickFiles(),
    () => canManage.peek(),
  ),
  plain(
    'View',
    'Enter VR',
    () => actions.page.enterVR(),
    () => inRecording() && state.xr.peek().supported === true,
  ),
];

export const COMMANDS: readonly KeyBinding[] = [...KEYS, ...MORE];
