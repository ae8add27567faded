import { expect, test } from 'vitest';
import { recordingRow } from '../../store/testing';
import { matching } from './recordings';

test('recordings are found by words of their names and ids, in any order', () => {
  const rows = [
    recordingRow('a-1', 'Street at night'),
    recordingRow('b-2', 'Street at noon'),
    recordingRow('c-3', 'Kitchen'),
  ];
  expect(matching(rows, '').length).toBe(3);
  expect(matching(rows, 'NIGHT street').map(({ id }) => id)).toEqual(['a-1']);
  expect(matching(rows, 'b-2').length).toBe(1);
  expect(matching(rows, 'garden')).toEqual([]);
});
