/** Frames laid over the one on screen: their placements, and the first hit of a ray on all of them. */
import type { Vec } from '../../store/types';
import { Matrix4, Vector3 } from 'three';
import type { CloudFrame } from './frame';
import { firstHit, type Hit } from './pick';

/** A frame, and where it lies over the one on screen; local coordinates. */
export interface PlacedFrame {
  readonly frame: CloudFrame;
  /** `T_shown_frame`. */
  readonly placed: Matrix4;
  /** Label → the same for its points: a tracked object lies where it is in the frame on screen. */
  readonly moving: ReadonlyMap<number, Matrix4>;
}

/** Points with one transform: the static points of a frame, or one object in it. */
export interface Layer {
  readonly frame: CloudFrame;
  /** `T_layer_shown`. */
  readonly inverse: Matrix4;
  /** Whether points of a label belong to it. */
  readonly holds: (label: number) => boolean;
}

/** A hit, and the frame of its point. */
export interface LayerHit extends Hit {
  readonly frame: CloudFrame;
}

export function layersOf({ frame, placed, moving }: PlacedFrame): Layer[] {
  const still = (label: number): boolean => !moving.has(label);
  const objects = [...moving].map(([own, T]) => ({
    frame,
    inverse: T.clone().invert(),
    holds: (label: number) => label === own,
  }));
  return [{ frame, inverse: placed.clone().invert(), holds: still }, ...objects];
}

const place = new Vector3();

/** A place of the frame on screen in the coordinates of a layer. */
export function placeIn({ inverse }: Layer, [x, y, z]: Vec): [number, number, number] {
  return place.set(x, y, z).applyMatrix4(inverse).toArray();
}

/** A direction of the frame on screen in the coordinates of a layer. */
export function directionIn({ inverse }: Layer, [x, y, z]: Vec): [number, number, number] {
  return place.set(x, y, z).transformDirection(inverse).toArray();
}

/** A clip box of the frame on screen (`T_cube_shown`) in the coordinates of a layer. */
export function clipIn({ inverse }: Layer, clip: Matrix4 | null): Matrix4 | null {
  return clip && clip.clone().multiply(inverse.clone().invert());
}

/** Return the first hit of a ray on `frame` and on the layers over it; see `firstHit`. */
export function firstHitAmong(
  frame: CloudFrame,
  layers: readonly Layer[],
  origin: Vec,
  direction: Vec,
  radius: number,
  visible: (label: number) => boolean,
  clip: Matrix4 | null = null,
  edit?: string,
): LayerHit | null {
  const own = firstHit(frame, origin, direction, radius, visible, clip, edit);
  let best: LayerHit | null = own && { ...own, frame };
  for (const layer of layers) {
    const seen = (label: number): boolean => layer.holds(label) && visible(label);
    const [from, way] = [placeIn(layer, origin), directionIn(layer, direction)];
    const hit = firstHit(layer.frame, from, way, radius, seen, clipIn(layer, clip), edit);
    if (hit === null || (best !== null && hit.distance >= best.distance)) continue;
    const at = (k: 0 | 1 | 2): number => origin[k] + direction[k] * hit.distance;
    best = { ...hit, position: [at(0), at(1), at(2)], frame: layer.frame };
  }
  return best;
}
