import { beforeEach, describe, expect, it } from 'vitest';
import { COMMANDS } from './commands';
import { state } from '../store/state';
import type { SequenceInfo } from '../protocol/messages';
import type { ProjectInfo } from '../protocol/values';
import { commandsNow, EVERYDAY, found, frameCommand, lastFirst, noteUsed } from './command-search';
import { projects } from '../engine/recordings/projects';
import { recordingRow } from '../store/testing';

function open(frames: number): void {
  state.sequence.value = {
    id: 'one',
    frames,
    fields: ['rgb'],
    sensors: [],
    lattice: null,
  } as unknown as SequenceInfo;
}

beforeEach(() => {
  state.sequence.value = null;
  state.palette.value = [];
  state.sequences.value = null;
  projects.value = [];
});

const EXPECTED: readonly (readonly [query: string, what: string])[] = [
  ['rubber', 'Eraser'],
  ['remove label', 'Eraser'],
  ['bounding box', 'Boxes of objects'],
  ['cuboid', 'Boxes of objects'],
  ['polygon', 'Polygon: click the corners of an outline'],
  ['lasso polygon', 'Polygon: click the corners of an outline'],
  ['rectangle', 'Rectangle: drag an outline from corner to corner'],
  ['frames laid over', 'Neighbouring frames: overlay or not'],
  ['overlay frames', 'Neighbouring frames: overlay or not'],
  ['several frames together', 'Neighbouring frames: overlay or not'],
  ['crop', 'Clip to a box or show everything'],
  ['clip follow', 'Clip box follows the active object: on or off'],
  ['merge labels', 'Merge car into van'],
  ['combine', 'Merge car into van'],
  ['split', 'Split the label into parts'],
  ['separate instances', 'Split the label into parts'],
  ['known truth', 'Agreement of annotators: compare, majority, ground truth'],
  ['majority', 'Agreement of annotators: compare, majority, ground truth'],
  ['consensus', 'Agreement of annotators: compare, majority, ground truth'],
  ['see through', 'Points behind the first surface: on or off'],
  ['provenance', 'Colour points by how they were labelled'],
  ['ai', 'Label by example: show or hide the prediction'],
  ['machine learning', 'Label by example: show or hide the prediction'],
  ['propagate', 'Track labels…'],
  ['download', 'Export points and labels…'],
  ['upload', 'Import files…'],
  ['magic wand', 'Fill'],
  ['bird eye', 'Look from above'],
  ['reset the view', 'Show everything'],
  ['remove points', 'Delete noise'],
  ['undelete', 'Restore deleted points'],
  ['revert', 'Undo'],
  ['eyedropper', 'Pick a label'],
  ['shortcuts', 'Keyboard and mouse'],
  ['log out', 'Sign out'],
  ['dark mode', 'Light or dark theme'],
  ['submit', 'Hand in my task and open the next'],
  ['approve', 'Mark this frame as checked'],
  ['reject', 'Mark this frame as to be corrected'],
];

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

  it('knows commands by everyday words', () => {
    open(10);
    state.me.value = { viewer: 'v', author: 'a', account: 'a', role: 'admin', serverVersion: '1' };
    const label = { category: '', color: '#ffffff', locked: false, visible: true };
    const night = { id: 'night', role: 'admin', tasks: {}, recordings: ['one'] };
    projects.value = [night as unknown as ProjectInfo];
    state.sequences.value = [{ ...recordingRow('one'), project: 'night' }];
    state.palette.value = ['car', 'van'].map((name, id) => ({ ...label, id: id + 1, name }));
    state.activeLabel.value = 1;
    const first = (query: string): string | undefined => found(commandsNow(), query)[0]?.what;
    const wrong = EXPECTED.filter(([query, what]) => first(query) !== what).map(([query, what]) => [
      query,
      what,
      first(query),
    ]);
    expect(wrong).toEqual([]);
    const texts = COMMANDS.map(({ what }) => what);
    expect(Object.keys(EVERYDAY).filter((what) => !texts.includes(what))).toEqual([]);
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
