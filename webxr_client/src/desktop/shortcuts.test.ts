import { beforeEach, describe, expect, it } from 'vitest';
import { renamedKeys, resetKeys, setKey, takeKeys } from '../store/own-keys';
import { state } from '../store/state';
import { commandsNow } from './command-search';
import { isFree, keyTable, printed } from './shortcuts';

function login(account: string): void {
  state.me.value = {
    viewer: 'v',
    author: 'Someone',
    account,
    role: 'annotator',
    serverVersion: '',
  };
}

const commandOf = (key: string): string | undefined => keyTable.value.get(key)?.what;

beforeEach(() => {
  for (const author of ['ada', 'bob']) {
    login(author);
    resetKeys();
  }
  login('ada');
});

describe('keys of one’s own', () => {
  it('are a person’s, and take a key away from what had it', () => {
    expect(commandOf('g')).toBe('Ground');
    setKey('Boxes: show or hide', 'g');
    expect(commandOf('g')).toBe('Boxes: show or hide');
    login('bob');
    expect(commandOf('g')).toBe('Ground');
    login('ada');
    setKey('Boxes: show or hide', null);
    expect(commandOf('g')).toBe('Ground');
  });

  it('are told wherever the key is', () => {
    state.sequence.value = {
      id: 'one',
      frames: 2,
      fields: [],
      sensors: [],
      lattice: null,
    } as never;
    setKey('Undo', 'ctrl+shift+u');
    expect(commandsNow().find(({ what }) => what === 'Undo')?.shown).toBe('Ctrl Shift U');
    expect(renamedKeys.value.get('Ctrl Z')).toBe('Ctrl Shift U');
    expect(commandOf('ctrl+z')).toBeUndefined();
    expect([' ', 'shift+arrowleft', 'ctrl++'].map(printed)).toEqual(['Space', 'Shift ←', 'Ctrl +']);
  });

  it('stay with a command whose words changed since they were stored', () => {
    takeKeys({ 'Ghost of the frame before: show or hide': 'f7', 'The box onto the ground': 'f8' });
    expect(commandOf('f7')).toBe('Ghost of the previous frame: show or hide');
    expect(commandOf('f8')).toBe('Snap the box to the ground');
  });

  it('are none that walk, or that dialogs need', () => {
    expect(['w', 'escape', 'tab', 'shift', 'ctrl+control'].filter(isFree)).toEqual([]);
    expect(['f9', 'ctrl+b', 'ö'].every(isFree)).toBe(true);
  });
});
