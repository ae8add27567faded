/**
 * All commands in one table: the keyboard uses it, the help lists its
 * shortcuts, and the command palette offers all of it.
 */
import { pickPalette, savePalette } from '../engine/labels/palette-files';
import { actions, type ViewPreset } from '../store/actions';
import { toggleExample } from '../example/store';
import { signOut } from '../engine/people/sign-out';
import { historyOpen } from '../panels/history-menu';
import { commandsOpen, helpOpen, exportOpen } from '../panels/parts/popover';
import { pickFiles } from '../panels/importing/files';
import { frameRange } from '../store/range';
import { limits } from '../store/limits';
import { renaming } from '../store/palette-list';
import { beginTour } from '../panels/tour-steps';
import { OVERLAYS } from '../panels/stage/view-options';
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
import { colourFields } from '../store/sensors';
import { chooseTheme, theme } from '../store/theme';
import { clip } from '../tools/clip';
import { outlineKind, type OutlineKind } from '../tools/lasso';
import { NOTE } from '../work/parts';
import { accept, judged, nextReview, nextTask } from '../work/queue';
import { reviewFrame, stepFindings } from '../work/review';
import { openWork } from '../work/store';
import { inGroup, key, KEYS, UNLISTED, type KeyBinding, type Ungrouped } from './keys';

const inRecording = (): boolean => state.sequence.peek() !== null;
const edits = (): boolean => inRecording() && canEdit.peek();
const hasLabel = (): boolean => edits() && activeLabel.peek() !== null;

const reviews = (): boolean => inRecording() && canReview.peek();
const judges = (): boolean => inRecording() && judged.peek() !== null;

/** Open the form for the note of the task to review. */
function writeNote(): void {
  openWork('tasks');
  requestAnimationFrame(() => document.getElementById(NOTE)?.focus());
}

/** A command that has no shortcut. */
function plain(what: string, run: () => unknown, when: () => boolean = inRecording): Ungrouped {
  return key([], what, run, { when });
}

function tool(name: Tool, what: string): Ungrouped {
  return plain(what, () => tools.setTool(name), edits);
}

function outline(kind: OutlineKind, what: string): Ungrouped {
  const choose = (): void => {
    tools.setShape('lasso');
    outlineKind.value = kind;
  };
  return plain(what, choose, edits);
}

type Switches<T> = { [K in keyof T]: T[K] extends boolean ? K : never }[keyof T];

function brushSwitch(name: Switches<BrushSettings>, what: string): Ungrouped {
  const turn = (): void => patch(state.brush, { [name]: !state.brush.peek()[name] });
  return plain(`${what}: on or off`, turn, edits);
}

function viewSwitch(name: Switches<ViewSettings>, what: string): Ungrouped {
  return plain(`${what}: show or hide`, () => view.setView({ [name]: !state.view.peek()[name] }));
}

function from(preset: ViewPreset, what: string): Ungrouped {
  return plain(what, () => view.viewFrom(preset));
}

function colour(color: ColorMode, what: string, field = ''): Ungrouped {
  return plain(
    `Colour points by ${what}`,
    () => view.setView({ color }),
    () => inRecording() && (!field || colourFields.peek().includes(field)),
  );
}

function label(what: string, run: (id: number) => unknown): Ungrouped {
  return plain(what, () => run(state.activeLabel.peek()), hasLabel);
}

const { labels, recordings, time, tools, tracking, view } = actions;

const WORK = [
  key('z', 'Next suspicious place', () => stepFindings(1)),
  key('shift+z', 'Previous suspicious place', () => stepFindings(-1)),
  key('shift+y', 'Confirm the doubtful labels of this frame', () => {
    if (canReview.peek()) void tracking.acceptFrame();
  }),
  key('ctrl+enter', 'Mark this frame as checked', () => reviewFrame('accepted')),
  key('ctrl+backspace', 'Mark this frame as to be corrected', () => reviewFrame('rejected')),
  key('shift+n', 'Hand in my task and open the next', () => nextTask()),
  plain('Review the next task', nextReview, reviews),
  plain('Accept the task', () => accept(judged.peek()!), judges),
  plain('Return the task with a note…', writeNote, judges),
  plain('Tasks of the project', () => openWork('tasks')),
  plain('Suspicious places', () => openWork('findings')),
  plain('States and notes of frames', () => openWork('frames')),
  plain(
    'Agreement of annotators: compare, majority, ground truth',
    () => openWork('agreement'),
    reviews,
  ),
  plain('Versions of the labels', () => openWork('versions')),
];

const TIME = [
  key('u', 'Next frame without labels', () => time.nextUnlabelled(1)),
  key('shift+u', 'Previous frame without labels', () => time.nextUnlabelled(-1)),
  key('shift+i', 'In point: the loop begins here', () => time.setIn()),
  key('shift+o', 'Out point: the loop ends here', () => time.setOut()),
  plain('Clear in and out points', () => (frameRange.value = null)),
  ...[0.1, 0.25, 0.5, 1, 2, 4].map((speed) =>
    plain(`Play at ${speed}×`, () => time.setSpeed(speed)),
  ),
];

const TOOLS = [
  tool('paint', 'Paint with the last shape'),
  outline('polygon', 'Polygon: click the corners of an outline'),
  outline('rectangle', 'Rectangle: drag an outline from corner to corner'),
  tool('floor', 'Set the floor'),
  plain('Reset the floor to the import', () => view.resetFloor(), edits),
  brushSwitch('onlyUnlabeled', 'Only unlabelled points'),
  brushSwitch('through', 'Points behind the first surface'),
  brushSwitch('takeLabelled', 'Take objects from other labels'),
  brushSwitch('complete', 'Offer objects after a stroke'),
  brushSwitch('follow', 'Follow painted labels'),
];

const LABELS = [
  label('Rename the label', (id) => (renaming.value = id)),
  label('Hide or show the label', (id) => labels.toggleVisible(id)),
  label('Lock or unlock the label', (id) => labels.toggleLock(id)),
  label('Show only the label, or all', (id) => labels.solo(id)),
  label('Split the label into parts', (id) => labels.splitLabel(id)),
  label('Delete the label', (id) => labels.deleteLabel(id)),
  plain('Add the labels of a palette file…', pickPalette, edits),
  plain('Save the palette as a file', savePalette),
];

const VIEW = [
  key('?', 'Keyboard and mouse', () => (helpOpen.value = true), { when: () => true }),
  plain('First steps: a tour of five cards', beginTour),
  plain(
    'Light or dark theme',
    () => chooseTheme(theme.peek() === 'light' ? 'dark' : 'light'),
    () => true,
  ),
  viewSwitch('hideUnlabeled', 'Only labelled points'),
  ...OVERLAYS.map(([name, what]) => viewSwitch(name, what)),
  viewSwitch('grid', 'Grid'),
  colour('rgb', 'source colour', 'rgb'),
  colour('intensity', 'intensity', 'intensity'),
  colour('height', 'height'),
  colour('distance', 'distance'),
  colour('normal', 'surface direction'),
  colour('plain', 'one colour'),
  colour('sensor', 'sensor', 'sensor'),
  colour('provenance', 'how they were labelled'),
  plain('Neighbouring frames: overlay or not', () =>
    patch(accumulation, { on: !accumulation.peek().on }),
  ),
  plain('Clip box follows the active object: on or off', () => {
    const now = clip.peek();
    if (now) clip.value = { ...now, follows: !now.follows };
  }),
  plain('Clip to a level slab', () => view.clipTo(1)),
  plain('Clip to a slab across the view', () => view.clipTo(2)),
  plain('Clip to a slab along the view', () => view.clipTo(0)),
  from('front', 'Look from the front'),
  from('left', 'Look from the left'),
  from('right', 'Look from the right'),
  from('fit', 'Show everything'),
  plain(
    'Enter VR',
    () => actions.page.enterVR(),
    () => inRecording() && state.xr.peek().supported === true,
  ),
];

const EDIT = [
  key('ctrl+k', 'All commands', () => (commandsOpen.value = limits.peek() === null), UNLISTED),
  plain(
    'Track labels…',
    () => (trackOpen.value = true),
    () => edits() && trackingJob.peek() === null,
  ),
  plain('Label by example: show or hide the prediction', () => toggleExample()),
  plain('Track forward from this frame', () => tracking.continueRun(), edits),
  plain('History of edits', () => (historyOpen.value = true)),
];

const RECORDINGS = [
  plain('Export points and labels…', () => (exportOpen.value = true)),
  plain('All recordings', () => recordings.closeSequence()),
  plain('Sign out', signOut, () => state.me.peek() !== null),
  plain(
    'Import files…',
    () => pickFiles(),
    () => canManage.peek(),
  ),
];

export const COMMANDS: readonly KeyBinding[] = [
  ...KEYS,
  ...inGroup('Work', WORK),
  ...inGroup('Time', TIME),
  ...inGroup('Tools', TOOLS),
  ...inGroup('Labels', LABELS),
  ...inGroup('View', VIEW),
  ...inGroup('Edit', EDIT),
  ...inGroup('Recordings', RECORDINGS),
];
