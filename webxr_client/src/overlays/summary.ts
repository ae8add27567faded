/** Summary of each label in a frame: the middle of its points, and an upright box round them. */
import { Matrix4 } from 'three';
import { type CloudFrame } from '../cloud/points/frame';
import { DELETED, type Piece } from '../cloud/points/piece';

/** Numbers kept for each label. */
const FIELDS = 9;
/** Most labels of a summary, far more than a person follows at a time. */
const MOST = 512;
/** Shortest time between two summaries of a frame with changing labels (during a stroke). */
const EVERY_MS = 80;

/** All lengths in metres of the room, y up. */
export class Summary {
  /** Labels present, in the order they were met. */
  readonly labels: number[] = [];
  readonly count: number[] = [];
  /** Middle of the points, middle of the box, half edges along its axes; see the getters. */
  readonly values = new Float32Array(FIELDS * MOST);
  /** Turn of the box about the vertical, radians. */
  readonly yaw = new Float32Array(MOST);
  versions = -1;
  time = -Infinity;

  /** Position of a label, or −1. */
  of(label: number): number {
    return this.labels.indexOf(label);
  }
}

/** Buffers for summarising a frame; grown when needed, and reused for every frame. */
class Scratch {
  /** Label → position in the summary, −1 while it was not met. */
  readonly slots = new Int16Array(65536).fill(-1);
  readonly moments = new Float64Array(7 * MOST);
  readonly bounds = new Float64Array(6 * MOST);
  /** Labels as shown, in stored order. */
  shown = new Uint16Array(0);
  /** Places in the room of the points that have a label, and the position of that. */
  places = new Float32Array(0);
  owners = new Uint16Array(0);
  points = 0;

  reserve(points: number): void {
    this.points = 0;
    if (this.shown.length >= points) return;
    this.shown = new Uint16Array(points);
    this.places = new Float32Array(3 * points);
    this.owners = new Uint16Array(points);
  }
}

export class Summaries {
  /** Counts the updated summaries. */
  version = 0;
  private known = new WeakMap<CloudFrame, Summary>();
  private readonly scratch = new Scratch();
  private readonly affine = new Float64Array(12);

  /** The summary of a frame as its labels are shown now (or were, a moment ago). */
  of(frame: CloudFrame, room: Matrix4, now: number): Summary {
    let summary = this.known.get(frame);
    if (!summary) this.known.set(frame, (summary = new Summary()));
    const versions = frame.version;
    if (summary.versions === versions || now - summary.time < EVERY_MS) return summary;
    summary.versions = versions;
    summary.time = now;
    this.version += 1;
    this.look(frame, room, summary);
    return summary;
  }

  /** Drop all summaries after the recording's placement has changed. */
  forget(): void {
    this.known = new WeakMap();
  }

  /** Return whether `of` would have to summarise the frame. */
  stale(frame: CloudFrame): boolean {
    return this.known.get(frame)?.versions !== frame.version;
  }

  /** Last summary of a frame. */
  peek(frame: CloudFrame): Summary | null {
    return this.known.get(frame) ?? null;
  }

  private look(frame: CloudFrame, room: Matrix4, out: Summary): void {
    out.labels.length = 0;
    out.count.length = 0;
    if (frame.blank) return;
    const { scratch } = this;
    scratch.reserve(frame.loaded);
    frame.gatherLabels(scratch.shown);
    for (const piece of frame.pieces) this.addUp(piece, room, out);
    turn(scratch, out);
    bound(scratch, out);
    finish(scratch, out);
    for (const label of out.labels) scratch.slots[label] = -1;
  }

  private addUp({ first, count, words, origin, scale }: Piece, room: Matrix4, out: Summary): void {
    const { affine: m, scratch } = this;
    const { shown, slots, moments, places, owners } = scratch;
    place(room, origin, scale, m);
    let n = scratch.points;
    for (let i = 0; i < count; i++) {
      const label = shown[first + i]!;
      if (label === 0 || label === DELETED) continue;
      let slot = slots[label]!;
      if (slot < 0) {
        if (out.labels.length >= MOST) continue;
        slot = slots[label] = out.labels.push(label) - 1;
        moments.fill(0, 7 * slot, 7 * slot + 7);
      }
      const a = words[6 * i]!;
      const b = words[6 * i + 1]!;
      const c = words[6 * i + 2]!;
      const x = m[0]! * a + m[1]! * b + m[2]! * c + m[3]!;
      const y = m[4]! * a + m[5]! * b + m[6]! * c + m[7]!;
      const z = m[8]! * a + m[9]! * b + m[10]! * c + m[11]!;
      const at = 7 * slot;
      moments[at]! += 1;
      moments[at + 1]! += x;
      moments[at + 2]! += y;
      moments[at + 3]! += z;
      moments[at + 4]! += x * x;
      moments[at + 5]! += z * z;
      moments[at + 6]! += x * z;
      places[3 * n] = x;
      places[3 * n + 1] = y;
      places[3 * n + 2] = z;
      owners[n] = slot;
      n += 1;
    }
    scratch.points = n;
  }
}

/** Extents along each label's own axes. */
function bound({ bounds, places, owners, points }: Scratch, out: Summary): void {
  for (let at = 0; at < 6 * out.labels.length; at += 2) {
    bounds[at] = Infinity;
    bounds[at + 1] = -Infinity;
  }
  for (let i = 0; i < points; i++) {
    const slot = owners[i]!;
    const x = places[3 * i]!;
    const y = places[3 * i + 1]!;
    const z = places[3 * i + 2]!;
    const cos = out.values[FIELDS * slot]!;
    const sin = out.values[FIELDS * slot + 1]!;
    const u = cos * x - sin * z;
    const v = sin * x + cos * z;
    const at = 6 * slot;
    if (u < bounds[at]!) bounds[at] = u;
    if (u > bounds[at + 1]!) bounds[at + 1] = u;
    if (y < bounds[at + 2]!) bounds[at + 2] = y;
    if (y > bounds[at + 3]!) bounds[at + 3] = y;
    if (v < bounds[at + 4]!) bounds[at + 4] = v;
    if (v > bounds[at + 5]!) bounds[at + 5] = v;
  }
}

/** From a piece's quantised coordinates to the room: three rows of four. */
function place(
  { elements: e }: Matrix4,
  origin: readonly number[],
  scale: readonly number[],
  m: Float64Array,
): void {
  for (let row = 0; row < 3; row++) {
    m[4 * row + 3] = e[12 + row]!;
    for (let column = 0; column < 3; column++) {
      const turned = e[4 * column + row]!;
      m[4 * row + column] = turned * scale[column]!;
      m[4 * row + 3]! += turned * origin[column]!;
    }
  }
}

/** The long way of each label's points on the floor; noted as cosine and sine for `bound`. */
function turn({ moments }: Scratch, out: Summary): void {
  for (let slot = 0; slot < out.labels.length; slot++) {
    const at = 7 * slot;
    const n = moments[at]!;
    const x = moments[at + 1]! / n;
    const z = moments[at + 3]! / n;
    const xx = moments[at + 4]! / n - x * x;
    const zz = moments[at + 5]! / n - z * z;
    const xz = moments[at + 6]! / n - x * z;
    const yaw = -0.5 * Math.atan2(2 * xz, xx - zz);
    out.yaw[slot] = yaw;
    out.values[FIELDS * slot] = Math.cos(yaw);
    out.values[FIELDS * slot + 1] = Math.sin(yaw);
  }
}

function finish({ moments, bounds }: Scratch, out: Summary): void {
  for (let slot = 0; slot < out.labels.length; slot++) {
    const n = moments[7 * slot]!;
    out.count.push(n);
    const at = FIELDS * slot;
    const b = 6 * slot;
    const cos = out.values[at]!;
    const sin = out.values[at + 1]!;
    const u = (bounds[b]! + bounds[b + 1]!) / 2;
    const v = (bounds[b + 4]! + bounds[b + 5]!) / 2;
    for (let k = 0; k < 3; k++) out.values[at + k] = moments[7 * slot + 1 + k]! / n;
    out.values[at + 3] = cos * u + sin * v;
    out.values[at + 4] = (bounds[b + 2]! + bounds[b + 3]!) / 2;
    out.values[at + 5] = cos * v - sin * u;
    for (let k = 0; k < 3; k++) {
      out.values[at + 6 + k] = (bounds[b + 2 * k + 1]! - bounds[b + 2 * k]!) / 2;
    }
  }
}

/** Offsets in `values`: the middle of the points, of the box, and its half edges. */
export const MIDDLE = 0;
export const BOX = 3;
export const HALF = 6;

/** Position in `values` of a label's field. */
export function at(slot: number, field: number): number {
  return FIELDS * slot + field;
}
