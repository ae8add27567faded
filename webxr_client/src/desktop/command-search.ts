/** Search of the command palette by words. */
import { actions } from '../store/actions';
import { keep, kept } from '../store/kept';
import { COMMANDS } from './commands';
import { activeLabel, canEdit, state } from '../store/state';
import { listed } from '../store/palette-list';
import { shownOf } from './shortcuts';

export interface Command {
  readonly what: string;
  /** Group, shown beside it. */
  readonly group: string;
  /** The shortcut to print. */
  readonly shown?: string;
  /** Other words that find it. */
  readonly also?: string;
  readonly run: () => unknown;
}

/** Synonyms of commands: text of the command, words. */
export const EVERYDAY: Readonly<Record<string, string>> = {
  'Agreement of annotators: compare, majority, ground truth': 'known truth gold consensus vote score difference quality iou',
  'All recordings': 'home start list files back',
  'Box from the label’s points in this frame': 'fit cuboid bounding automatic',
  'Boxes of objects': 'bounding box cuboid draw detection 3d',
  Box: 'cube select area volume',
  Cluster: 'connected points group',
  'Clip box follows the active object: on or off': 'crop track moving',
  'Clip to a box or show everything': 'crop cut out region isolate hide outside section',
  'Clip to a level slab': 'crop height slice floor ceiling section',
  'Colour points by how they were labelled': 'provenance origin source painted tracked',
  'Delete noise': 'remove points outlier dust clean',
  Eraser: 'rubber unlabel wipe clear remove label',
  'Export points and labels…': 'save download file',
  Fill: 'magic wand bucket flood region grow',
  'Follow painted labels: on or off': 'auto track',
  'Go to the active label’s object': 'find focus zoom center centre',
  Ground: 'floor plane wall surface',
  'Hand in my task and open the next': 'submit finish done send',
  'History of edits': 'changes log versions past',
  'Import files…': 'upload load open add new recording',
  'Interpolate between two drawn boxes': 'in between keyframe',
  'Keyboard and mouse': 'help shortcut hotkey',
  'Label by example: show or hide the prediction': 'ai machine learning auto classifier predict automatic segmentation',
  'Light or dark theme': 'mode night bright appearance',
  'Look from above': 'top bird eye plan map',
  'Mark this frame as checked': 'approve accept ok good done',
  'Mark this frame as to be corrected': 'reject wrong bad return',
  'Neighbouring frames: overlay or not': 'accumulate merge stack several frames laid over together',
  'New label': 'add create class category',
  'Next suspicious place': 'problem error check finding',
  Object: 'smart select click segment instance',
  'Only labelled points: show or hide': 'hide unlabelled unlabeled background',
  'Only unlabelled points: on or off': 'unlabeled keep protect other labels overwrite',
  Paint: 'brush pen draw annotate colour',
  'Pick a label': 'eyedropper pipette',
  'Points behind the first surface: on or off': 'through see deep depth hidden x-ray',
  'Polygon: click the corners of an outline': 'lasso select area',
  'Rectangle: drag an outline from corner to corner': 'lasso select box area',
  'Restore deleted points': 'undelete bring back recover',
  'Set the floor': 'ground level height up',
  'Show everything': 'fit zoom reset view all home',
  'Sign out': 'log out logout user account',
  'Split the label into parts': 'separate divide instances cut',
  'Track labels…': 'propagate copy next frames follow auto interpolate',
  Undo: 'revert back mistake',
}; // prettier-ignore

/** Commands that make sense now: the table's, and one for each label and recording. */
export function commandsNow(): readonly Command[] {
  const table = COMMANDS.filter(
    ({ listed: shown, when }) => shown !== false && (when?.() ?? state.sequence.peek() !== null),
  ).map((binding) => ({
    what: binding.what,
    group: binding.group,
    shown: shownOf(binding),
    also: EVERYDAY[binding.what] ?? '',
    run: () => binding.run(binding.keys[0] ?? ''),
  }));
  const active = activeLabel.peek();
  const merges = listed.peek().flatMap(({ id, name, locked }) =>
    !canEdit.peek() || !active || active.locked || locked || id === active.id
      ? []
      : [
          {
            what: `Merge ${active.name} into ${name}`,
            group: 'Labels',
            also: 'combine join unite labels',
            run: () => actions.labels.mergeLabel(active.id, id),
          },
        ],
  );
  const labels = listed.peek().map(({ id, name }) => ({
    what: `Choose ${name}`,
    group: 'Labels',
    run: () => actions.labels.selectLabel(id),
  }));
  const open = state.sequence.peek()?.id;
  const recordings = (state.sequences.peek() ?? [])
    .filter(({ id, damaged }) => id !== open && damaged === null)
    .map(({ id, name }) => ({
      what: `Open ${name}`,
      group: 'Recordings',
      run: () => actions.recordings.openSequence(id),
    }));
  return [...table, ...labels, ...recordings, ...merges];
}

/** Stop words of a search. */
const SMALL = new Set(['a', 'the', 'of', 'to', 'my', 'with', 'how']);

/**
 * Return the commands with every word, best first: at the beginning of the text, then of a word,
 * then of one of its other words.
 */
export function found<T extends Omit<Command, 'run'>>(
  commands: readonly T[],
  query: string,
): readonly T[] {
  const queryWords = query.toLowerCase().split(/\s+/).filter(Boolean);
  const words = queryWords
    .filter((word) => queryWords.length === 1 || !SMALL.has(word))
    .map(singular);
  const rank = ({ what, group, shown = '', also = '' }: T): number => {
    const text = `${what} ${group} ${shown}`.toLowerCase();
    let sum = 0;
    for (const word of words) {
      const at = text.indexOf(word);
      const other = ` ${also}`.includes(` ${word}`);
      if (at < 0 && !other) return -1;
      sum += at === 0 ? 0 : text.includes(` ${word}`) ? 1 : other ? 2 : 3;
    }
    return sum;
  };
  return commands
    .map((command) => ({ command, rank: rank(command) }))
    .filter((each) => each.rank >= 0)
    .sort((a, b) => a.rank - b.rank)
    .map(({ command }) => command);
}

/** A word without the s of its plural. */
function singular(word: string): string {
  return word.length > 3 ? word.replace(/s$/, '') : word;
}

const KEY = 'pointbrush.last-command';

/** Store the last command in this browser, so that the palette opens on it. */
export function noteUsed({ what }: Pick<Command, 'what'>): void {
  keep(KEY, what);
}

/** The commands with the one that was used last in front. */
export function lastFirst<T extends Pick<Command, 'what'>>(commands: readonly T[]): readonly T[] {
  const last = kept(KEY);
  const used = commands.filter(({ what }) => what === last);
  return used.length > 0 ? [...used, ...commands.filter(({ what }) => what !== last)] : commands;
}

/** A number typed into the palette leads to its frame. */
export function frameCommand(query: string): readonly Command[] {
  const frames = state.sequence.peek()?.frames ?? 0;
  const frame = /^\d+$/.test(query.trim()) ? Number(query) : -1;
  if (frame < 0 || frame >= frames) return [];
  return [{ what: `Go to frame ${frame}`, group: 'Time', run: () => actions.time.seek(frame) }];
}
