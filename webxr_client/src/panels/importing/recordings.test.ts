import { expect, test } from 'vitest';
import { matching } from './recordings';

const row = (id: string, name: string) => ({
  id, name, frames: 1, fps: 1, points: 1, damaged: null, labels_missing: null, created: null,
  labelled: 0, labels: 0, labels_used: 0, identity: null,
  project: 'default',
}); // prettier-ignore

test('recordings are found by words of their names and ids, in any order', () => {
  const rows = [row('a-1', 'Street at night'), row('b-2', 'Street at noon'), row('c-3', 'Kitchen')];
  expect(matching(rows, '').length).toBe(3);
  expect(matching(rows, 'NIGHT street').map(({ id }) => id)).toEqual(['a-1']);
  expect(matching(rows, 'b-2').length).toBe(1);
  expect(matching(rows, 'garden')).toEqual([]);
});
