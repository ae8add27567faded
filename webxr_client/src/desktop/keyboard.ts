/** Listens to the keyboard by the person's table of keys. */
import { boxKey } from '../boxes/keys';
import type { DeskCamera } from '../view/camera';
import { isForControl, releaseSlider } from '../common/focus';
import type { KeyBinding } from './keys';
import { keyTable } from './shortcuts';

/** Return an event's key as `KEYS` writes it. */
export function keyName(event: KeyboardEvent): string {
  // The key beside 1 gives an accent that waits for a letter on many keyboards.
  const key = event.code === 'Backquote' ? '`' : event.key.toLowerCase();
  const printable = key.length === 1 && !/[a-z]/.test(key);
  let name = key;
  // Shift is already in the character that a punctuation key gives.
  if (event.shiftKey && !printable) name = `shift+${name}`;
  if (event.altKey) name = `alt+${name}`;
  if (event.ctrlKey || event.metaKey) name = `ctrl+${name}`;
  return name;
}

/** Return the digit on the key that is pressed with Shift, for any character; null: none. */
function shiftedDigit({
  code,
  key,
  shiftKey,
  ctrlKey,
  metaKey,
  altKey,
}: KeyboardEvent): string | null {
  if (!shiftKey || ctrlKey || metaKey || altKey || /\d/.test(key)) return null;
  return /^Digit([1-9])$/.exec(code)?.[1] ?? null;
}

function typing(target: EventTarget | null): boolean {
  if (!(target instanceof HTMLElement)) return false;
  if (target instanceof HTMLInputElement)
    return target.type !== 'range' && target.type !== 'checkbox';
  return target.isContentEditable || target.matches('textarea, select');
}

/** The character's own meaning goes first: keyboards have / and + above digits. */
function bindingOf(name: string, digit: string | null): KeyBinding | undefined {
  const table = keyTable.peek();
  return table.get(name) ?? (digit ? table.get(`shift+${digit}`) : undefined);
}

function run(binding: KeyBinding, event: KeyboardEvent, key: string): void {
  const runs = !event.repeat || binding.repeats === true;
  if (runs && binding.run(key) === false) return;
  event.preventDefault();
}

export function listenToKeys(camera: DeskCamera): void {
  const down = (event: KeyboardEvent): void => {
    if (typing(event.target) || event.defaultPrevented || isForControl(event)) return;
    if (boxKey(event)) event.preventDefault();
    else pressed(event);
  };
  const pressed = (event: KeyboardEvent): void => {
    const name = keyName(event);
    const digit = shiftedDigit(event);
    const binding = bindingOf(name, digit);
    if (binding) {
      // A button that was clicked does not keep Space.
      if (name === ' ' && event.target instanceof HTMLButtonElement) event.target.blur();
      run(binding, event, digit ?? event.key.toLowerCase());
      return;
    }
    if (!event.ctrlKey && !event.metaKey && !event.altKey) {
      if (camera.key(event.key.toLowerCase(), true)) event.preventDefault();
    }
  };
  const up = (event: KeyboardEvent): void => {
    bindingOf(keyName(event), null)?.released?.();
    camera.key(event.key.toLowerCase(), false);
  };
  const blur = (): void => {
    for (const binding of keyTable.peek().values()) binding.released?.();
    camera.releaseKeys();
  };
  addEventListener('keydown', down);
  addEventListener('keyup', up);
  addEventListener('blur', blur);
  document.getElementById('view')?.addEventListener('pointerenter', releaseSlider);
}
