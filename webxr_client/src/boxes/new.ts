/** Boxes that are drawn from nothing: over the floor, or by one click in the size of their class. */
import { signal } from '@preact/signals';
import type { Matrix4 } from 'three';
import { api } from '../net/rest';
import type { Label } from '../protocol/messages';
import type { Taxonomy } from '../protocol/values';
import { actions } from '../store/actions';
import { boxes, type Triple } from '../store/boxes';
import { activeLabel, state } from '../store/state';
import type { Volume } from '../tools/volume';
import { addBox } from './changes';
import { lengthwise, shapeOf } from './volume';

/** The next press on the recording draws a box. */
export const drawing = signal(false);

/** Length, width, height of classes without a size in the taxonomy, by parts of their names. */
const SIZES: readonly (readonly [RegExp, Triple])[] = [
  [/bus/, [11, 2.9, 3.3]],
  [/truck|lorry/, [8, 2.6, 3.2]],
  [/van/, [5.2, 2, 2.1]],
  [/cycl|bike|bicycle/, [1.8, 0.7, 1.7]],
  [/motor/, [2.1, 0.8, 1.5]],
  [/person|pedestrian|human|people/, [0.7, 0.7, 1.75]],
  [/car|vehicle/, [4.4, 1.85, 1.6]],
];

/** Size that a click gives a label's box: its class's in the taxonomy, or the usual one; else null. */
async function sizeOf({ category, name }: Label): Promise<Triple | null> {
  const words = `${category} ${name}`.toLowerCase();
  const usual = SIZES.find(([part]) => part.test(words))?.[1] ?? null;
  const { categories } = await api<Taxonomy>('GET', 'taxonomy');
  return categories.find((one) => one.name === category)?.size ?? usual;
}

/** The volume of a click: on the ground that it was put on, of the size of the label's class. */
async function classSized(volume: Volume): Promise<Volume> {
  const label = activeLabel.peek();
  const size = label && (await sizeOf(label).catch(() => null));
  if (!size) return volume;
  const bottom = volume.center[1] - volume.size[1] / 2;
  const [x, , z] = volume.center;
  const [length, width, height] = size;
  return { ...volume, center: [x, bottom + height / 2, z], size: [length, height, width] };
}

/**
 * Make a box of a volume of the room.  The active label's, where it has none in this frame; else
 * that of a new label of the same class.  `clicked`: nothing was dragged.
 */
export async function makeBox(volume: Volume, room: Matrix4, clicked: boolean): Promise<void> {
  drawing.value = false;
  const info = state.sequence.peek();
  if (!info) return;
  const sized = clicked ? await classSized(volume) : lengthwise(volume);
  const { frame } = state.shown.peek();
  const label = activeLabel.peek();
  const taken = [...boxes.peek().values()].some(
    (box) => box.label === label?.id && frame in box.poses,
  );
  if (!label || taken)
    await actions.labels.createLabel(undefined, undefined, label?.category ?? '');
  await addBox(shapeOf(sized, room, info.shift));
}
