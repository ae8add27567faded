import { Vector3 } from 'three';
import { expect, it } from 'vitest';
import { frameOf, wall } from '../cloud/testing';
import { whereIs } from '../cloud/whereabouts';
import { addBookmark, bookmarks, openBookmarks, removeBookmark, renameBookmark } from './bookmarks';
import { nearestWith } from './going';

it('finds where a label is, as shown', () => {
  const frame = frameOf(wall(20, 1000));
  expect(whereIs(frame, 3)).toBeNull();
  frame.setOverlay('stroke', { indices: Uint32Array.of(0, 1, 2), values: Uint16Array.of(3) });
  const place = whereIs(frame, 3)!;
  expect(place.points).toBe(3);
  expect(place.middle.distanceTo(new Vector3(0.01, 0, 1))).toBeLessThan(1e-5);
  expect(place.radius).toBeGreaterThan(0.005);
});

it('finds the nearest frame that has a label', () => {
  const points = Uint32Array.of(4, 0, 0, 0, 7, 0);
  const none = new Uint32Array(6);
  const row = { points, painted: none, confidence: new Float32Array(6), state: new Uint8Array(6) };
  expect(nearestWith(row, 3)).toBe(4);
  expect(nearestWith(row, 1)).toBe(0);
  expect(nearestWith({ ...row, points: none }, 1)).toBeNull();
  expect(nearestWith(undefined, 0)).toBeNull();
});

it('keeps views for each recording, and reads nothing that is no view', () => {
  const memory = new Map<string, string>();
  const storage = { getItem: (k: string) => memory.get(k) ?? null, setItem: (k: string, v: string) => void memory.set(k, v) }; // prettier-ignore
  Object.defineProperty(globalThis, 'localStorage', { value: storage, configurable: true });
  const view = { eye: [0, 1, 2], target: [0, 0, 0], half: 0 } as const;
  openBookmarks('one');
  addBookmark(view, 3);
  addBookmark(view, 5);
  renameBookmark(1, '  the corner ');
  openBookmarks('two');
  expect(bookmarks.value).toEqual([]);
  openBookmarks('one');
  expect(bookmarks.value.map(({ name, frame }) => [name, frame])).toEqual([['View 1', 3], ['the corner', 5]]); // prettier-ignore
  removeBookmark(0);
  expect(bookmarks.value).toHaveLength(1);
  memory.set(
    'pointbrush.views.bad',
    '[{"name": 3}, {"name": "x", "frame": 1, "view": {"eye": [1]}}]',
  );
  openBookmarks('bad');
  expect(bookmarks.value).toEqual([]);
});
