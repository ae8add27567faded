import { beforeEach, describe, expect, it } from 'vitest';
import { COMMANDS } from './commands';
import { state } from '../store/state';
import type { SequenceInfo } from '../protocol/messages';
import { commandsNow, found, frameCommand, lastFirst, noteUsed } from './command-search';
import { recordingRow } from '../store/testing';

function open(frames: number): void {
  state.sequence.value = { id: 'one', frames, fields: ['rgb'] } as unknown as SequenceInfo;
}

beforeEach(() => {
  state.sequence.value = null;
  state.palette.value = [];
  state.sequences.value = null;
});

describe('the command palette', () => {
  it('finds commands by words in any order, the best first', () => {
    open(10);
    const texts = found(commandsNow(), 'frame one').map(({ what }) => what);
    expect(texts.slice(0, 2)).toEqual(['One frame back', 'One frame forward']);
    expect(found(commandsNow(), 'nonsense')).toEqual([]);
  });

  it('offers labels, other recordings and frames', () => {
    open(10);
    const label = { id: 4, name: 'left hand', category: '', color: '#ffffff' };
    state.palette.value = [{ ...label, locked: false, visible: true }];
    state.sequences.value = ['one', 'two'].map((id) => recordingRow(id));
    const texts = commandsNow().map(({ what }) => what);
    expect(texts).toContain('Choose left hand');
    expect(texts).toContain('Open two');
    expect(texts).not.toContain('Open one');
    expect(frameCommand('7').map(({ what }) => what)).toEqual(['Go to frame 7']);
    expect(frameCommand('10')).toEqual([]);
  });

  it('offers only what makes sense now', () => {
    const texts = commandsNow().map(({ what }) => what);
    expect(texts).toContain('Keyboard and mouse');
    expect(texts).not.toContain('Play or pause');
    open(10);
    expect(commandsNow().some(({ what }) => what.includes('intensity'))).toBe(false);
  });

  it('opens on what was used last', () => {
    open(10);
    noteUsed({ what: 'Boxes: show or hide' });
    expect(lastFirst(commandsNow())[0]?.what).toBe('Boxes: show or hide');
    expect(lastFirst(commandsNow())).toHaveLength(commandsNow().length);
  });

  it('says each thing once', () => {
    const texts = COMMANDS.map(({ what }) => what);
    expect(new Set(texts).size).toBe(texts.length);
  });
});
