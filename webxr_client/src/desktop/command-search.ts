/** Search of the command palette by words. */
import { actions } from '../store/actions';
import { keep, kept } from '../store/kept';
import { COMMANDS } from './commands';
import { state } from '../store/state';
import { listed } from '../store/palette-list';
import { shownOf } from './shortcuts';

export interface Command {
  readonly what: string;
  /** Group, shown beside it. */
  readonly group: string;
  /** The shortcut to print; empty when there is none. */
  readonly shown: string;
  readonly run: () => unknown;
}

/** Commands that make sense now: the table's, and one for each label and recording. */
export function commandsNow(): readonly Command[] {
  const table = COMMANDS.filter(
    ({ listed: shown, when }) => shown !== false && (when?.() ?? state.sequence.peek() !== null),
  ).map((binding) => ({
    what: binding.what,
    group: binding.group,
    shown: shownOf(binding),
    run: () => binding.run(binding.keys[0] ?? ''),
  }));
  const labels = listed.peek().map(({ id, name }) => ({
    what: `Choose ${name}`,
    group: 'Labels',
    shown: '',
    run: () => actions.selectLabel(id),
  }));
  const open = state.sequence.peek()?.id;
  const recordings = (state.sequences.peek() ?? [])
    .filter(({ id, damaged }) => id !== open && damaged === null)
    .map(({ id, name }) => ({
      what: `Open ${name}`,
      group: 'Recordings',
      shown: '',
      run: () => actions.openSequence(id),
    }));
  return [...table, ...labels, ...recordings];
}

/** Return the commands with every word, best first: at the beginning of the text, then of a word. */
export function found<T extends Omit<Command, 'run'>>(
  commands: readonly T[],
  query: string,
): readonly T[] {
  const words = query.toLowerCase().split(/\s+/).filter(Boolean);
  const rank = ({ what, group, shown }: T): number => {
    const text = `${what} ${group} ${shown}`.toLowerCase();
    let sum = 0;
    for (const word of words) {
      const at = text.indexOf(word);
      if (at < 0) return -1;
      sum += at === 0 ? 0 : text.includes(` ${word}`) ? 1 : 2;
    }
    return sum;
  };
  return commands
    .map((command) => ({ command, rank: rank(command) }))
    .filter((each) => each.rank >= 0)
    .sort((a, b) => a.rank - b.rank)
    .map(({ command }) => command);
}

const KEY = 'pointbrush.last-command';

/** Keep in this browser what was used last, so that the palette opens on it. */
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
  return [
    { what: `Go to frame ${frame}`, group: 'Time', shown: '', run: () => actions.seek(frame) },
  ];
}
