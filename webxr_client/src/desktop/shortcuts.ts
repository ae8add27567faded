/** The keys of commands as this person has them. */
import { computed, type ReadonlySignal } from '@preact/signals';
import { ownKeys, renamedKeys } from '../store/own-keys';
import { follow } from '../store/watch';
import { COMMANDS } from './commands';
import { type KeyBinding, WALK_KEYS } from './keys';

/** Keys for walking, and keys that every dialog and form needs. */
const FIXED = new Set([...WALK_KEYS.shown.toLowerCase().split(' '), 'escape', 'tab', 'shift+tab']);
const NAMES: Readonly<Record<string, string>> = {
  ' ': 'Space',
  arrowleft: '←',
  arrowright: '→',
  arrowup: '↑',
  arrowdown: '↓',
  pageup: 'Page ↑',
  pagedown: 'Page ↓',
  escape: 'Esc',
  '-': '−',
};

/** Return whether a command may get another key; digits are reserved for labels. */
export function isChangeable({ keys, listed }: KeyBinding): boolean {
  return listed !== false && keys.length <= 2;
}

/** Whether a key may be given to a command. */
export function isFree(key: string): boolean {
  return (
    !FIXED.has(key) && !/^(ctrl\+|alt\+|shift\+)*(control|shift|alt|meta|dead|altgraph)$/.test(key)
  );
}

/** A key in print, from how the table writes it. */
export function printed(key: string): string {
  const parts = /^((?:ctrl\+|alt\+|shift\+)*)(.+)$/s.exec(key);
  const [held = '', name = key] = parts?.slice(1) ?? [];
  const words = [...held.split('+').filter(Boolean), NAMES[name] ?? name];
  return words.map((word) => word.charAt(0).toUpperCase() + word.slice(1)).join(' ');
}

/** The keys of a command: the person's own, else its first ones that no other has been given. */
export function keysOf(binding: KeyBinding): readonly string[] {
  const own = ownKeys.value;
  const mine = own[binding.what];
  if (mine !== undefined) return [mine];
  const given = new Set(Object.values(own));
  return binding.keys.filter((key) => !given.has(key));
}

/** The same in print; empty when it has none. */
export function shownOf(binding: KeyBinding): string {
  const keys = keysOf(binding);
  if (binding.shown && keys.length === binding.keys.length) return binding.shown;
  return keys[0] === undefined ? '' : printed(keys[0]);
}

/** Key → command. */
export const keyTable: ReadonlySignal<ReadonlyMap<string, KeyBinding>> = computed(
  () => new Map(COMMANDS.flatMap((each) => keysOf(each).map((key) => [key, each] as const))),
);

follow(() => {
  const renamed = new Map<string, string>();
  for (const each of COMMANDS) {
    const first = each.shown ?? printed(each.keys[0] ?? '');
    if (first !== shownOf(each)) renamed.set(first, shownOf(each));
  }
  renamedKeys.value = renamed;
});
