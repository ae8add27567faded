import { describe, expect, it } from 'vitest';
import { keyName } from './keyboard';
import { COMMANDS } from './commands';
import { WALK_KEYS } from './keys';

function press(key: string, held: Partial<KeyboardEvent> = {}): string {
  const none = { shiftKey: false, altKey: false, ctrlKey: false, metaKey: false };
  return keyName({ key, ...none, ...held } as KeyboardEvent);
}

describe('keys', () => {
  it('each have one meaning', () => {
    const all = COMMANDS.flatMap((binding) => binding.keys);
    expect(new Set(all).size).toBe(all.length);
    // These keys walk; a tool on one of them would also move the camera.
    for (const key of WALK_KEYS.shown.toLowerCase().split(' ')) expect(all).not.toContain(key);
  });

  it('are named as the table writes them', () => {
    expect(press(' ')).toBe(' ');
    expect(press('ArrowLeft', { shiftKey: true })).toBe('shift+arrowleft');
    expect(press('Z', { ctrlKey: true, shiftKey: true })).toBe('ctrl+shift+z');
    expect(press('z', { metaKey: true })).toBe('ctrl+z');
    // Some keyboards have brackets above Shift or AltGr: the character counts.
    expect(press('[', { shiftKey: true })).toBe('[');
  });
});
