/** Listens to the keyboard by the table of `keys.ts`. */
import type { DeskCamera } from './camera';
import { KEYS, type KeyBinding } from './keys';

const table = new Map<string, KeyBinding>();
for (const binding of KEYS) for (const key of binding.keys) table.set(key, binding);

/** How `KEYS` writes the key of an event. */
export function keyName(event: KeyboardEvent): string {
  const key = event.key.toLowerCase();
  const printable = key.length === 1 && !/[a-z]/.test(key);
  let name = key;
  // Shift is already in the character that a punctuation key gives.
  if (event.shiftKey && !printable) name = `shift+${name}`;
  if (event.altKey) name = `alt+${name}`;
  if (event.ctrlKey || event.metaKey) name = `ctrl+${name}`;
  return name;
}

function typing(target: EventTarget | null): boolean {
  if (!(target instanceof HTMLElement)) return false;
  if (target instanceof HTMLInputElement)
    return target.type !== 'range' && target.type !== 'checkbox';
  return target.isContentEditable || target.matches('textarea, select');
}

/** The result stops listening. */
export function listenToKeys(camera: DeskCamera): () => void {
  const down = (event: KeyboardEvent): void => {
    if (typing(event.target) || event.defaultPrevented) return;
    const name = keyName(event);
    const binding = table.get(name);
    if (binding) {
      // Space and Enter press the focused button; everywhere else they are ours.
      if (name === ' ' && event.target instanceof HTMLButtonElement) event.target.blur();
      const runs = !event.repeat || binding.repeats === true;
      if (runs && binding.run(event.key.toLowerCase()) === false) return;
      event.preventDefault();
      return;
    }
    if (!event.ctrlKey && !event.metaKey && !event.altKey) {
      if (camera.key(event.key.toLowerCase(), true)) event.preventDefault();
    }
  };
  const up = (event: KeyboardEvent): void => void camera.key(event.key.toLowerCase(), false);
  const blur = (): void => camera.releaseKeys();
  addEventListener('keydown', down);
  addEventListener('keyup', up);
  addEventListener('blur', blur);
  return () => {
    removeEventListener('keydown', down);
    removeEventListener('keyup', up);
    removeEventListener('blur', blur);
  };
}
