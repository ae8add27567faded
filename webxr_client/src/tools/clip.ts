/** The clip box: points outside it are neither shown nor met nor taken, by any tool. */
import { computed, signal, type ReadonlySignal } from '@preact/signals';
import { Matrix4, type Vector3 } from 'three';
import { cubeOf } from '../cloud/points/clipping';
import type { ClipBox } from '../protocol/messages';
import { state } from '../store/state';
import { axisOf, ENDLESS, shifted, toSource, type Volume } from './volume';

export interface Clip {
  readonly volume: Volume;
  /** A slab goes on without end along the two other axes. */
  readonly slab: 0 | 1 | 2 | null;
  /** It goes along with the active label's object from frame to frame. */
  readonly follows: boolean;
}

/** Null: all points are shown. */
export const clip = signal<Clip | null>(null);

/** A notch of the wheel moves a slab by this part of its thickness. */
const SCROLL = 0.25;

const room: ReadonlySignal<Matrix4> = computed(() => {
  const rows = state.sequence.value?.room;
  return rows ? new Matrix4().set(...(rows as Parameters<Matrix4['set']>)) : new Matrix4();
});

/** The box as strokes have it, source coordinates. */
export const clipBox: ReadonlySignal<Required<ClipBox> | null> = computed(() => {
  const { value } = clip;
  const info = state.sequence.value;
  if (!value || !info) return null;
  const { volume, slab } = value;
  const size = volume.size.map((edge, axis) => (slab === null || axis === slab ? edge : ENDLESS));
  return toSource({ ...volume, size: size as [number, number, number] }, room.value, info.shift);
});

/** `T_cube_local`: shown points lie in the cube of edges 2; null: all points are shown. */
export const clipMatrix: ReadonlySignal<Matrix4 | null> = computed(() => {
  const box = clipBox.value;
  const info = state.sequence.value;
  return box && info ? cubeOf(box, info.shift) : null;
});

/** `T_cube_room`: the same for places of the room. */
export const clipInRoom: ReadonlySignal<Matrix4 | null> = computed(
  () => clipMatrix.value?.clone().multiply(room.value.clone().invert()) ?? null,
);

/** The thinnest way through the box, which it is scrolled along. */
function scrolled({ volume, slab }: Clip): 0 | 1 | 2 {
  if (slab !== null) return slab;
  const { size } = volume;
  return size.indexOf(Math.min(...size)) as 0 | 1 | 2;
}

/** Move the box through the recording, by notches of the wheel; false without one. */
export function scrollClip(notches: number): boolean {
  const now = clip.peek();
  if (!now) return false;
  const axis = scrolled(now);
  const by = axisOf(now.volume, axis).multiplyScalar(notches * SCROLL * now.volume.size[axis]);
  clip.value = { ...now, volume: shifted(now.volume, by) };
  return true;
}

/** Its middle to a place of the room. */
export function centerClip(at: Vector3): void {
  const now = clip.peek();
  if (now) clip.value = { ...now, volume: { ...now.volume, center: at.toArray() } };
}
