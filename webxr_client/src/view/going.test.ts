import { Group, Vector3 } from 'three';
import { expect, it } from 'vitest';
import type { CloudFrame } from '../cloud/points/frame';
import { Lens } from '../cloud/picture/lens';
import { frameOf, wall } from '../cloud/points/testing';
import { placeOfLabel } from '../cloud/points/whereabouts';
import { addBookmark, bookmarks, openBookmarks, removeBookmark, renameBookmark } from './bookmarks';
import { DeskCamera } from './camera';
import { state } from '../store/state';
import { followsObject, LabelNavigation, nearestWith } from './going';

it('finds where a label is, as shown', () => {
  const frame = frameOf(wall(20, 1000));
  expect(placeOfLabel(frame, 3)).toBeNull();
  frame.setOverlay('stroke', { indices: Uint32Array.of(0, 1, 2), values: Uint16Array.of(3) });
  const place = placeOfLabel(frame, 3)!;
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

/** A frame with two points of a label, with their middle at these millimetres. */
function withLabel(label: number, x: number, y: number, z: number): CloudFrame {
  const frame = frameOf([[x - 5, y, z], [x + 5, y, z], [0, 0, 0]]); // prettier-ignore
  frame.setOverlay('stroke', { indices: Uint32Array.of(0, 1), values: Uint16Array.of(label) });
  return frame;
}

it('goes along with the active label from frame to frame', () => {
  const camera = new DeskCamera(new Lens());
  let frame: CloudFrame | null = withLabel(3, 1000, 500, 2000);
  const room = new Group();
  room.position.set(0, 1, 0);
  room.updateMatrixWorld();
  const navigation = new LabelNavigation({
    viewer: { room, invalidate: () => undefined },
    camera,
    frame: () => frame,
    seek: () => undefined,
  });
  const eye = (): Vector3 => camera.camera.position.clone();
  const show = (shown: CloudFrame | null): Vector3 => {
    const before = eye();
    frame = shown;
    navigation.update();
    return eye().sub(before);
  };
  state.activeLabel.value = 3;
  const still = eye();
  navigation.update();
  expect(eye().equals(still)).toBe(true);

  followsObject.value = true;
  navigation.update();
  expect(camera.pivot.distanceTo(new Vector3(1, 1.5, 2))).toBeLessThan(1e-5);
  expect(show(withLabel(3, 1200, 600, 1900)).distanceTo(new Vector3(0.2, 0.1, -0.1))).toBeLessThan(1e-5); // prettier-ignore
  // Lost for a frame: the camera waits, and catches up in the next that has it.
  expect(show(withLabel(4, 9000, 9000, 9000)).length()).toBe(0);
  expect(show(null).length()).toBe(0);
  show(withLabel(3, 1500, 700, 1900));
  expect(camera.pivot.distanceTo(new Vector3(1.5, 1.7, 1.9))).toBeLessThan(1e-5);
  // A person's own turn is kept; another label is brought to the middle.
  const direction = camera.camera.quaternion.clone();
  show(withLabel(3, 1600, 700, 1900));
  expect(camera.camera.quaternion.equals(direction)).toBe(true);
  state.activeLabel.value = 5;
  show(withLabel(5, 300, 200, 100));
  expect(camera.pivot.distanceTo(new Vector3(0.3, 1.2, 0.1))).toBeLessThan(1e-5);
  followsObject.value = false;
  expect(show(withLabel(5, 900, 900, 900)).length()).toBe(0);
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
