/**
 * Ghost of the labelled objects in the previous frame: some of their points, in grey, to distinguish
 * them from labelled points.
 */
import { BufferGeometry, DynamicDrawUsage, Float32BufferAttribute, Points, type Object3D, type RawShaderMaterial } from 'three'; // prettier-ignore
import { type CloudFrame } from '../cloud/points/frame';
import { dotMaterial, type PointUniforms } from '../cloud/picture/material';
import { DELETED } from '../cloud/points/piece';
import type { ColorMode, ViewSettings } from '../store/types';
import { isShown } from './shown';

/** Most points of a ghost; more would look like labelled points of this frame. */
const MOST = 1500;
/** Metres. */
const DOT = 0.01;
/** Linear, of red, green and blue: seen before the dark and the light background. */
const GREY = 0.35;
const OPACITY = 0.6;
/** Colourings that one judges labels by: nothing may lie over them. */
const JUDGING: readonly ColorMode[] = ['label', 'confidence', 'provenance'];

/** Return whether a ghost may be drawn: while time stands, except when labels are judged. */
export function isGhostAllowed(
  { ghost, color }: Pick<ViewSettings, 'ghost' | 'color'>,
  playing: boolean,
  doubtful: boolean,
): boolean {
  return ghost && !playing && !doubtful && !JUDGING.includes(color);
}

export class Ghost {
  /** Points on screen. */
  count = 0;
  private readonly points: Points<BufferGeometry, RawShaderMaterial>;

  /** `room`: points are placed in local coordinates. */
  constructor(room: Object3D, uniforms: PointUniforms) {
    const geometry = new BufferGeometry();
    const places = new Float32BufferAttribute(new Float32Array(3 * MOST), 3);
    const colors = new Float32BufferAttribute(new Float32Array(4 * MOST), 4);
    geometry.setAttribute('position', places.setUsage(DynamicDrawUsage));
    geometry.setAttribute('color', colors.setUsage(DynamicDrawUsage));
    this.points = new Points(geometry, dotMaterial(uniforms, DOT));
    this.points.frustumCulled = false;
    this.points.visible = false;
    this.points.renderOrder = 59;
    room.add(this.points);
  }

  hide(): void {
    this.points.visible = false;
    this.count = 0;
  }

  /** The points of a label in a frame, of all labels shown when it has none there. */
  show(frame: CloudFrame, active: number): void {
    const only = has(frame, active) ? active : 0;
    const total = countOf(frame, only);
    const step = Math.max(1, Math.ceil(total / MOST));
    const { position, color } = this.points.geometry.attributes;
    let met = 0;
    let count = 0;
    let last = 0;
    let shown = false;
    for (const { labels, words, origin, scale } of frame.pieces) {
      if (!labels) continue;
      for (let i = 0, w = 0; i < labels.length && count < MOST; i++, w += 6) {
        const label = labels[i]!;
        if (!wanted(label, only) || met++ % step !== 0) continue;
        if (label !== last) {
          last = label;
          shown = isShown(label);
        }
        if (!shown) continue;
        position!.setXYZ(
          count,
          origin[0] + words[w]! * scale[0],
          origin[1] + words[w + 1]! * scale[1],
          origin[2] + words[w + 2]! * scale[2],
        );
        color!.setXYZW(count, GREY, GREY, GREY, OPACITY);
        count += 1;
      }
    }
    this.count = count;
    this.points.visible = count > 0;
    this.points.geometry.setDrawRange(0, count);
    position!.needsUpdate = color!.needsUpdate = true;
  }
}

function wanted(label: number, only: number): boolean {
  return only === 0 ? label !== 0 && label !== DELETED : label === only;
}

function has(frame: CloudFrame, label: number): boolean {
  return label !== 0 && frame.pieces.some((piece) => piece.labels?.includes(label) ?? false);
}

function countOf(frame: CloudFrame, only: number): number {
  let count = 0;
  for (const { labels } of frame.pieces) {
    if (labels) for (const label of labels) if (wanted(label, only)) count += 1;
  }
  return count;
}
