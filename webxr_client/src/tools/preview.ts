/** Preview of a stroke, found on the page's own points, shown until the server has answered. */
import type { PointerSample, Vec } from '../store/types';
import { Matrix4, Quaternion } from 'three';
import { layers } from '../cloud/points/accumulation';
import { cubeOf } from '../cloud/points/clipping';
import type { CloudFrame } from '../cloud/points/frame';
import { insideOutline } from '../cloud/points/inside';
import { clipIn, directionIn, firstHitAmong, type Layer, placeIn } from '../cloud/points/layer';
import { alongRay, inBox, inCapsule } from '../cloud/points/pick';
import { DELETED } from '../cloud/points/piece';
import { runsOf } from '../protocol/codec';
import type { Brush, TouchedPoints } from '../protocol/messages';
import { isDeleted, type Seen } from './seen';
import { Touched } from './touched';

/** Whether a label may not be changed. */
export type Locked = (label: number) => boolean;

/** Shapes with points that the page finds itself. */
const PREVIEWED_SHAPES: ReadonlySet<string> = new Set(['sphere', 'ray', 'lasso', 'box']);
/** Most bytes of runs with which the page sends the points of a stroke. */
const MOST_RUN_BYTES = 2 ** 20;
/** Preview of a stroke that is still drawn or placed as one piece: shown until it is made. */
const AHEAD = 'ahead';

/** The part of a preview that lies on one frame, or on one object of a frame laid over it. */
class Part {
  private readonly touched = new Touched();
  private readonly values: Uint16Array;

  constructor(
    private readonly id: string,
    /** The stroke's id. */
    private readonly edit: string,
    readonly frame: CloudFrame,
    private readonly layer: Layer | null,
    private readonly brush: Brush,
    private readonly locked: Locked,
    private readonly seen: Seen,
    /** Source minus local coordinates. */
    shift: Vec,
    /** `T_cube_frame` of the box outside which nothing is taken. */
    private readonly clip: Matrix4 | null,
  ) {
    const { tool, label } = brush;
    const value = tool === 'paint' ? (label ?? 0) : tool === 'delete' ? DELETED : 0;
    this.values = Uint16Array.of(value);
    this.take(shift);
  }

  /** Points that the stroke would change, as far as they were shown. */
  get points(): number {
    return this.touched.size;
  }

  /** All points are here. */
  get whole(): boolean {
    return this.frame.complete && !this.frame.large;
  }

  /** Points in the shape, including points that the stroke does not change. */
  met(): TouchedPoints {
    return { frame: this.frame.index, runs: runsOf(this.touched.met().sort()) };
  }

  /** The points of a shape that needs no samples. */
  private take([x, y, z]: Vec): void {
    const { layer } = this;
    const { shape, polygon, matrix, center, size, quaternion } = this.brush;
    if (shape === 'lasso' && polygon && matrix) {
      const T = new Matrix4().set(...(matrix as Parameters<Matrix4['set']>));
      T.multiply(new Matrix4().makeTranslation(x, y, z));
      if (layer) T.multiply(layer.inverse.clone().invert());
      insideOutline(this.frame, polygon, T.transpose().toArray(), this.touch, this.clip);
    }
    if (shape === 'box' && center && size) {
      const local: Vec = [center[0] - x, center[1] - y, center[2] - z];
      const turn = new Quaternion(...(quaternion ?? [0, 0, 0, 1]));
      if (layer) turn.premultiply(new Quaternion().setFromRotationMatrix(layer.inverse));
      const { x: i, y: j, z: k, w } = turn;
      const middle = layer ? placeIn(layer, local) : local;
      inBox(this.frame, middle, size, [i, j, k, w], this.touch, this.clip);
    }
  }

  sphere(from: Vec, to: Vec, radius: number): void {
    const { layer } = this;
    const [a, b] = layer ? [placeIn(layer, from), placeIn(layer, to)] : [from, to];
    inCapsule(this.frame, a, b, radius, this.touch, this.clip);
  }

  along(origin: Vec, direction: Vec, radius: number): void {
    const { layer } = this;
    const [a, b] = layer
      ? [placeIn(layer, origin), directionIn(layer, direction)]
      : [origin, direction];
    alongRay(this.frame, a, b, radius, this.touch, this.clip);
  }

  private readonly touch = (point: number): void => {
    if (this.layer?.holds(this.frame.storedLabelOf(point)) === false) return;
    if (!this.touched.meet(point)) return;
    if (this.applies(this.frame.labelOf(point, this.edit))) this.touched.take(point);
  };

  private applies(current: number): boolean {
    const { tool, label, only_unlabeled: onlyUnlabeled } = this.brush;
    if (tool === 'restore') return current === DELETED;
    if (!this.seen(current) || this.locked(current)) return false;
    if (tool === 'erase') return current !== 0;
    if (tool === 'delete') return !(onlyUnlabeled && current !== 0);
    return current !== label && !(onlyUnlabeled && current !== 0);
  }

  show(): void {
    const { touched, values } = this;
    if (!touched.settle()) return;
    const indices = touched.numbers.subarray(0, touched.size);
    const overlay = { indices, values };
    const { edit } = this;
    this.frame.setOverlay(this.id, edit === AHEAD ? overlay : { ...overlay, edit });
  }

  drop(): void {
    this.frame.dropOverlay(this.id);
  }
}

export class StrokePreview {
  /** Place of the sphere at the last sample. */
  private readonly last: [number, number, number] = [NaN, NaN, NaN];
  private readonly parts: readonly Part[];
  private readonly clip: Matrix4 | null;
  /** Every point that the stroke may take was here when it began. */
  private readonly whole: boolean;

  constructor(
    readonly id: string,
    private readonly frame: CloudFrame,
    private readonly brush: Brush,
    locked: Locked,
    private readonly seen: Seen,
    /** Source minus local coordinates. */
    shift: Vec,
    /** Frames laid over the one on screen. */
    private readonly layers: readonly Layer[] = [],
  ) {
    const clip = brush.clip ? cubeOf(brush.clip, shift) : null;
    this.clip = clip;
    const part = (name: string, of: CloudFrame, layer: Layer | null): Part =>
      new Part(name, id, of, layer, brush, locked, seen, shift, layer ? clipIn(layer, clip) : clip);
    const others = layers.map((layer, k) => part(`${id}:${k}`, layer.frame, layer));
    this.parts = [part(id, frame, null), ...others];
    this.whole =
      PREVIEWED_SHAPES.has(brush.shape ?? 'sphere') && this.parts.every((one) => one.whole);
  }

  /** Points that the stroke would change, as far as they were shown. */
  get points(): number {
    return this.parts.reduce((sum, part) => sum + part.points, 0);
  }

  /**
   * Points that the stroke takes, so that the server changes the shown points.  Null if it has to
   * select: it may find points that are not here.
   */
  taken(): TouchedPoints[] | null {
    if (!this.whole || !this.parts.every((part) => part.whole)) return null;
    const taken = this.parts.map((part) => part.met()).filter(({ runs }) => runs.length > 0);
    const bytes = taken.reduce((sum, { runs }) => sum + runs.length, 0);
    return bytes <= MOST_RUN_BYTES ? taken : null;
  }

  /** Take in a sample. */
  add({ origin, direction }: PointerSample): void {
    const { brush, frame, last, parts } = this;
    const radius = brush.radius ?? 0.05;
    if (brush.shape === 'ray' && brush.through) {
      for (let i = 0; i < parts.length; i++) parts[i]!.along(origin, direction, radius);
    } else if (brush.shape === 'ray') {
      const meets = brush.tool === 'restore' ? isDeleted : this.seen;
      const { layers, clip, id } = this;
      const hit = firstHitAmong(frame, layers, origin, direction, radius, meets, clip, id);
      if (hit) this.sphere(hit.position, hit.position, radius);
    } else if (brush.shape === 'sphere') {
      this.sphere(Number.isNaN(last[0]) ? origin : last, origin, radius);
      for (let k = 0; k < 3; k++) last[k] = origin[k]!;
    }
  }

  private sphere(from: Vec, to: Vec, radius: number): void {
    for (let i = 0; i < this.parts.length; i++) this.parts[i]!.sphere(from, to, radius);
  }

  /** Show the points found since the last call. */
  show(): void {
    for (let i = 0; i < this.parts.length; i++) this.parts[i]!.show();
  }

  /** Remove the preview. */
  drop(): void {
    for (const part of this.parts) part.drop();
  }
}

interface AheadDeps {
  readonly locked: Locked;
  readonly seen: Seen;
  /** Source minus local coordinates. */
  readonly shift: () => Vec;
  readonly changed: () => void;
}

export class AheadPreview {
  /** Points that the stroke would change. */
  points = 0;
  private frame: CloudFrame | null = null;
  private preview: StrokePreview | null = null;

  constructor(private readonly deps: AheadDeps) {}

  show(frame: CloudFrame, brush: Brush): void {
    if (this.frame !== frame) this.hide();
    const { locked, seen, shift, changed } = this.deps;
    const preview = new StrokePreview(AHEAD, frame, brush, locked, seen, shift(), layers.peek());
    this.preview?.drop();
    preview.show();
    this.preview = preview;
    this.points = preview.points;
    this.frame = frame;
    changed();
  }

  hide(): void {
    if (this.preview) {
      this.preview.drop();
      this.deps.changed();
    }
    this.frame = this.preview = null;
    this.points = 0;
  }
}
