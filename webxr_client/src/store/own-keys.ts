/** A person's own keys: this browser's copy of each account's, which the server keeps. */
import { computed, signal, type ReadonlySignal } from '@preact/signals';
import { keep, kept } from './kept';
import { state } from './state';
import { follow } from './watch';

/** Command, by its words → key as the keyboard's table writes it. */
export type OwnKeys = Readonly<Record<string, string>>;

const place: ReadonlySignal<string> = computed(
  () => `pointbrush.keys.${state.me.value?.account ?? ''}`,
);
const chosen = signal<OwnKeys>({});
export const ownKeys: ReadonlySignal<OwnKeys> = chosen;

/** As printed → the key that a person has in its place: for tooltips. */
export const renamedKeys = signal<ReadonlyMap<string, string>>(new Map());

/** Keys that a person chose since the page opened, for the server to store; null: none. */
export const keysToStore = signal<OwnKeys | null>(null);

follow(() => {
  chosen.value = parsed(kept(place.value));
  keysToStore.value = null;
});

function parsed(text: string | null): OwnKeys {
  try {
    const found: unknown = JSON.parse(text ?? '{}');
    if (typeof found !== 'object' || found === null) return {};
    return Object.fromEntries(Object.entries(found).filter(([, key]) => typeof key === 'string'));
  } catch {
    return {};
  }
}

/** Give a command a key, which another one loses; null: its own again. */
export function setKey(command: string, key: string | null): void {
  const others = Object.entries(chosen.peek()).filter(
    ([what, held]) => what !== command && held !== key,
  );
  change(Object.fromEntries(key === null ? others : [...others, [command, key]]));
}

export function resetKeys(): void {
  change({});
}

/** Take the keys that the server keeps. */
export function takeKeys(keys: OwnKeys): void {
  chosen.value = keys;
  keep(place.peek(), JSON.stringify(keys));
}

function change(keys: OwnKeys): void {
  takeKeys(keys);
  keysToStore.value = keys;
}
