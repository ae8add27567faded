/** The ways of the labelled objects through the frames near the playhead. */
import { BufferAttribute, BufferGeometry, DynamicDrawUsage, LineBasicMaterial, LineSegments, Points, type Color, type Matrix4, type Object3D, type RawShaderMaterial } from 'three'; // prettier-ignore
import { shows } from '../cloud/points/clipping';
import { dotMaterial, type PointUniforms } from '../cloud/picture/material';
import { colorOf, isShown } from './shown';
import { at, MIDDLE, type Summary } from './summary';

/** Frames before and after the playhead. */
export const REACH = 45;
export const PLACES = 2 * REACH + 1;
const DOTS = 4096;
/** Metres. */
const DOT = 0.02;
/** Missing frames that the line still bridges. */
const BRIDGE = 3;

/** An attribute of which the first values go to the GPU; three.js would make a range each time. */
class Prefix extends BufferAttribute {
  private readonly range = { start: 0, count: 0 };

  constructor(size: number, most: number) {
    super(new Float32Array(size * most), size);
    this.setUsage(DynamicDrawUsage);
    this.updateRanges.push(this.range);
    // There is one: sorting them would only make garbage.
    this.updateRanges.sort = () => this.updateRanges;
  }

  renew(count: number): void {
    this.range.count = count * this.itemSize;
    this.needsUpdate = true;
  }

  /** Called after each upload: the range is used again. */
  override clearUpdateRanges(): void {
    return;
  }
}

/** Places with colours, some of which are on screen. */
class Vertices {
  readonly geometry = new BufferGeometry();
  private readonly places: Prefix;
  private readonly colors: Prefix;

  constructor(readonly most: number) {
    this.geometry.setAttribute('position', (this.places = new Prefix(3, most)));
    this.geometry.setAttribute('color', (this.colors = new Prefix(4, most)));
  }

  set(index: number, values: Float32Array, from: number, color: Color, alpha: number): void {
    const places = this.places.array;
    const colors = this.colors.array;
    for (let k = 0; k < 3; k++) places[3 * index + k] = values[from + k]!;
    colors[4 * index] = color.r;
    colors[4 * index + 1] = color.g;
    colors[4 * index + 2] = color.b;
    colors[4 * index + 3] = alpha;
  }

  copy(index: number, other: Vertices, from: number): void {
    this.places.copyAt(index, other.places, from);
    this.colors.copyAt(index, other.colors, from);
  }

  /** Show the first ones. */
  reveal(object: Object3D, count: number): void {
    object.visible = count > 0;
    this.geometry.setDrawRange(0, count);
    this.places.renew(count);
    this.colors.renew(count);
  }
}

export class Trails {
  /** Dots on screen. */
  count = 0;
  private readonly dots = new Vertices(DOTS);
  private readonly ends = new Vertices(2 * DOTS);
  private readonly points: Points<BufferGeometry, RawShaderMaterial>;
  readonly lines: LineSegments<BufferGeometry, LineBasicMaterial>;

  constructor(world: Object3D, uniforms: PointUniforms) {
    const look = { transparent: true, depthTest: false, vertexColors: true };
    this.lines = new LineSegments(this.ends.geometry, new LineBasicMaterial(look));
    // A dot for each frame: a line alone is a hair in a headset.
    this.points = new Points(this.dots.geometry, dotMaterial(uniforms, DOT));
    this.points.material.depthTest = false;
    for (const object of [this.lines, this.points]) {
      object.frustumCulled = false;
      object.visible = false;
      world.add(object);
    }
    this.lines.renderOrder = 60;
    this.points.renderOrder = 61;
  }

  hide(): void {
    this.lines.visible = this.points.visible = false;
    this.count = 0;
  }

  /** `summaryOf` returns a frame's summary or null; `clip`: `T_cube_room` of shown places. */
  show(
    head: number,
    frames: number,
    labels: readonly { readonly id: number }[],
    summaryOf: (frame: number) => Summary | null,
    clip: Matrix4 | null,
  ): void {
    const { dots, ends } = this;
    const first = Math.max(0, head - REACH);
    const last = Math.min(frames - 1, head + REACH);
    let count = 0;
    let joined = 0;
    for (let i = 0; i < labels.length; i++) {
      const label = labels[i]!.id;
      if (!isShown(label)) continue;
      const color = colorOf(label);
      let before = -Infinity;
      for (let frame = first; frame <= last && count < DOTS; frame++) {
        const summary = summaryOf(frame);
        const slot = summary ? summary.of(label) : -1;
        if (slot < 0) continue;
        const { values } = summary!;
        const place = at(slot, MIDDLE);
        if (clip && !shows(clip, values[place]!, values[place + 1]!, values[place + 2]!)) {
          // A line over the places left out would leave the clip box.
          before = -Infinity;
          continue;
        }
        // Points farther away in time are fainter.
        const near = 1 - (0.75 * Math.abs(frame - head)) / REACH;
        dots.set(count, values, place, color, near);
        if (frame - before <= BRIDGE) {
          ends.copy(joined++, dots, count - 1);
          ends.copy(joined++, dots, count);
        }
        before = frame;
        count += 1;
      }
    }
    this.count = count;
    dots.reveal(this.points, count);
    ends.reveal(this.lines, joined);
  }
}
