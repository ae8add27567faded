import { expect, test } from 'vitest';
import { recordingRow } from '../../store/testing';
import { matching, sorted } from './list';

const ROWS = [
  { ...recordingRow('a-1', 'Street 10'), frames: 4, labelled: 2, changed: '2026-11-02T10:00:00Z' },
  { ...recordingRow('b-2', 'Street 9'), frames: 4, labelled: 1, changed: '2026-11-03T10:00:00Z' },
  { ...recordingRow('c-3', 'Kitchen'), frames: 2, labelled: 1, changed: '2026-11-01T10:00:00Z' },
];

test('recordings are found by words of their names and ids, in any order', () => {
  const found = (text: string): string[] => matching(ROWS, text).map(({ id }) => id);
  expect(found('').length).toBe(3);
  expect(found('10 STREET')).toEqual(['a-1']);
  expect(found('b-2')).toEqual(['b-2']);
  expect(found('garden')).toEqual([]);
});

test('recordings are sorted by number in the name, by share of labelled frames, by change', () => {
  const ids = (...how: [Parameters<typeof sorted>[1], boolean]): string =>
    sorted(ROWS, ...how).map(({ id }) => id[0]).join(''); // prettier-ignore
  expect(ids('name', false)).toBe('cba');
  expect(ids('progress', true)).toBe('cab');
  expect(ids('changed', true)).toBe('bac');
});
