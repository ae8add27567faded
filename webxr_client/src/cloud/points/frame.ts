/** A frame of points in the page's memory, and the label of each point. */
import type { LabelUpdate } from '../../net/wire';
import {
  imageBuffers,
  type DepthImage,
  type Segment,
  type SegmentChunk,
} from '../../net/chunk/segment';
import type { Shown } from '../../store/types';
import { depthPiece } from './depth-piece';
import { merged, sorted, type Overlay } from './overlay';
import { applyDelta, applyRuns, lowerBound, pieceOf, type Piece } from './piece';

/** Ids of all points in stored order, or of the points with ascending stored `numbers`. */
export interface Predicted {
  readonly numbers: Uint32Array | null;
  readonly ids: Uint16Array;
}

export class CloudFrame {
  readonly pieces: Piece[] = [];
  total = 0;
  /** Points here; the first `loaded` ones, except in large frames. */
  loaded = 0;
  complete = false;
  bytes = 0;
  /** Grow with every change of points, and of labels. */
  pointsVersion = 0;
  labelsVersion = 0;
  /** Of depth cameras; none where points came as points. */
  images: readonly DepthImage[] = [];
  readonly overlays = new Map<string, Overlay>();
  /** Prediction, as ids of the palette's texture; null: none. */
  predicted: Predicted | null = null;
  private readonly buffers = new Set<ArrayBuffer>();
  /** Last answer of `shown`, and the versions then. */
  private lastShown: Shown | null = null;
  private lastShownVersion = -1;
  /** Label values that came before their points. */
  private early: LabelUpdate[] = [];

  constructor(
    readonly index: number,
    /** Chunks of large frames come in any order; others only as a growing prefix. */
    readonly large: boolean,
  ) {}

  /**
   * Take in decoded points.  False when they are not used: already here, or not joining on
   * (then `gap` is true, and the frame must be requested again).
   */
  add(segment: Segment): boolean {
    const chunks = segment.chunks.filter((chunk) => !this.has(chunk));
    this.total = segment.total;
    if (!this.large && chunks.length > 0 && chunks[0]!.first !== this.loaded) return false;
    if (chunks.length > 0) for (const image of segment.images) this.sharpen(image);
    const bytes = new Uint8Array(segment.vertices);
    for (const chunk of chunks) this.addPiece(this.pieceFrom(chunk, bytes));
    this.complete ||= segment.final && (this.large || this.loaded === this.total);
    if (chunks.length === 0) return false;
    this.hold(segment.vertices);
    this.pointsVersion += 1;
    return true;
  }

  private pieceFrom(chunk: SegmentChunk, segment: Uint8Array<ArrayBuffer>): Piece {
    return this.imageOf(chunk.sensor) ? depthPiece(this, chunk) : pieceOf(chunk, segment);
  }

  /** The image of a depth camera; undefined where its points came as points. */
  imageOf(sensor: number): DepthImage | undefined {
    return this.images.find((image) => image.sensor === sensor);
  }

  /** Take in an image with more pixels, which keeps the colours where it brings none. */
  private sharpen(image: DepthImage): void {
    const { images } = this;
    const at = images.findIndex(({ sensor }) => sensor === image.sensor);
    const before = images[at];
    const after = { ...image, colours: image.colours ?? before?.colours ?? null };
    this.images = before ? images.with(at, after) : [...images, after];
    const held = imageBuffers(after);
    for (const buffer of held) this.hold(buffer);
    if (!before) return;
    for (const buffer of imageBuffers(before)) if (!held.includes(buffer)) this.drop(buffer);
  }

  private hold(buffer: ArrayBuffer): void {
    if (this.buffers.has(buffer)) return;
    this.buffers.add(buffer);
    this.bytes += buffer.byteLength;
  }

  private drop(buffer: ArrayBuffer): void {
    this.buffers.delete(buffer);
    this.bytes -= buffer.byteLength;
  }

  private has(chunk: SegmentChunk): boolean {
    if (!this.large) return chunk.first < this.loaded;
    return this.pieces.some((piece) => piece.index === chunk.index);
  }

  private addPiece(piece: Piece): void {
    const { first, count } = piece;
    if (this.pieces.length === 0 || this.pieces.at(-1)!.first < first) this.pieces.push(piece);
    else this.pieces.splice(this.after(first), 0, piece);
    this.loaded += count;
    for (const update of this.early) this.applyTo(piece, update);
    this.forgetEarly(piece);
  }

  /** Label values are kept only for points that are not here yet. */
  private forgetEarly(piece: Piece): void {
    const stop = piece.first + piece.count;
    if (!this.large) {
      if (this.loaded === this.total) this.early = [];
      return;
    }
    this.early = this.early.filter(
      (update) =>
        update.base !== null || update.first < piece.first || update.first + update.count > stop,
    );
    if (this.early.every((update) => update.base !== null)) this.early = [];
  }

  /** Drop a chunk of a large frame; returns the buffer that brought it once nothing needs it. */
  remove(index: number): ArrayBuffer | null {
    const at = this.pieces.findIndex((piece) => piece.index === index);
    const piece = this.pieces[at];
    if (!piece) return null;
    this.pieces.splice(at, 1);
    this.loaded -= piece.count;
    this.pointsVersion += 1;
    const { buffer } = piece.words;
    if (this.pieces.some((other) => other.words.buffer === buffer)) return null;
    this.drop(buffer);
    return buffer;
  }

  /** The buffers, to be recycled; the frame is empty afterwards. */
  release(): ArrayBuffer[] {
    this.pieces.length = 0;
    this.loaded = 0;
    this.bytes = 0;
    this.complete = false;
    this.images = [];
    this.pointsVersion += 1;
    const buffers = [...this.buffers];
    this.buffers.clear();
    return buffers;
  }

  /** Apply the server's values, whole or delta. */
  applyLabels(update: LabelUpdate): void {
    // Points still to come take their values from here, in the order that they were given.
    if (!this.complete && (update.base === null || this.early.length > 0)) this.early.push(update);
    for (const piece of this.pieces) this.applyTo(piece, update);
    this.labelsVersion += 1;
  }

  private applyTo(piece: Piece, update: LabelUpdate): void {
    if (update.base === null) applyRuns(piece, update);
    else applyDelta(piece, update.lengths, update.values);
  }

  /** Whether it is known to have no points. */
  get empty(): boolean {
    return this.complete && this.total === 0;
  }

  /** Description while it is on screen; another object after each change, and only then. */
  get shown(): Shown {
    const { index, loaded, total, version } = this;
    if (!this.lastShown || this.lastShownVersion !== version) {
      this.lastShown = { frame: index, points: loaded, total };
      this.lastShownVersion = version;
    }
    return this.lastShown;
  }

  /** Another number after each change of points or labels. */
  get version(): number {
    return this.labelsVersion * 4096 + this.pointsVersion;
  }

  /** Whether nothing has a label, as shown. */
  get blank(): boolean {
    if (this.overlays.size > 0) return false;
    for (let i = 0; i < this.pieces.length; i++) if (this.pieces[i]!.labels) return false;
    return true;
  }

  /** Write the labels as shown of the first `count` points into `out`. */
  gatherLabels(out: Uint16Array, count = this.loaded): void {
    for (let i = 0; i < this.pieces.length; i++) {
      const { labels, first, count: points } = this.pieces[i]!;
      if (first + points > count) continue;
      if (labels) out.set(labels, first);
      else out.fill(0, first, first + points);
    }
    if (this.overlays.size === 0) return;
    for (const { indices, values } of this.overlays.values()) {
      const single = values.length === 1;
      const stop = lowerBound(indices, count);
      for (let i = 0; i < stop; i++) out[indices[i]!] = values[single ? 0 : i]!;
    }
  }

  /** Show predictions on points without a label; null: none. */
  predict(values: Predicted | null): void {
    if (values === null && this.predicted === null) return;
    this.predicted = values;
    this.labelsVersion += 1;
  }

  /** Write predictions of the points from `first` on into `out` where it is 0. */
  fillPredicted(out: Uint16Array, first: number, count: number): void {
    if (!this.predicted) return;
    const { numbers, ids } = this.predicted;
    let at = numbers ? lowerBound(numbers, first) : first;
    for (; at < ids.length; at++) {
      const place = (numbers ? numbers[at]! : at) - first;
      if (place >= count) return;
      if (out[place] === 0) out[place] = ids[at]!;
    }
  }

  /** `gatherLabels`, with predictions on points without a label. */
  gatherShown(out: Uint16Array, count = this.loaded): void {
    this.gatherLabels(out, count);
    this.fillPredicted(out, 0, count);
  }

  /** Number of the first piece that begins after `number`. */
  private after(number: number): number {
    let low = 0;
    let high = this.pieces.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.pieces[middle]!.first <= number) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** The piece that holds a stored number, if it is here. */
  pieceOf(number: number): Piece | null {
    const piece = this.pieces[this.after(number) - 1];
    return piece && number < piece.first + piece.count ? piece : null;
  }

  /**
   * The label of a point as shown: overlays first.  With `edit`: as the server will find it when it
   * applies that edit, after the earlier edits on their way.
   */
  labelOf(number: number, edit?: string): number {
    let value = this.storedLabelOf(number);
    for (const overlay of this.overlays.values()) {
      if (edit !== undefined && (overlay.edit === undefined || overlay.edit === edit)) continue;
      const at = search(overlay.indices, number);
      if (at >= 0) value = overlay.values[overlay.values.length === 1 ? 0 : at]!;
    }
    return value;
  }

  /** The label of a point as the server has it. */
  storedLabelOf(number: number): number {
    const piece = this.pieceOf(number);
    return piece?.labels?.[number - piece.first] ?? 0;
  }

  /** Stored numbers of a label's points that are here, as the server has them. */
  pointsOf(label: number): Uint32Array {
    const found: number[] = [];
    for (const { first, labels } of this.pieces) {
      labels?.forEach((each, i) => {
        if (each === label) found.push(first + i);
      });
    }
    return Uint32Array.from(found);
  }

  setOverlay(id: string, overlay: Overlay): void {
    this.overlays.set(id, overlay);
    this.labelsVersion += 1;
  }

  /** Add to an overlay; new values replace its values of the same points. */
  mergeOverlay(id: string, indices: Uint32Array, values: Uint16Array): void {
    const before = this.overlays.get(id);
    const news = sorted({ indices, values });
    this.setOverlay(id, before ? merged(before, news) : news);
  }

  dropOverlay(id: string): boolean {
    const dropped = this.overlays.delete(id);
    if (dropped) this.labelsVersion += 1;
    return dropped;
  }
}

function search(numbers: Uint32Array, number: number): number {
  const at = lowerBound(numbers, number);
  return numbers[at] === number ? at : -1;
}

/** Density of the frame's first `shown` points over the piece's level: scales its spacing. */
export function densityFactor(frame: CloudFrame, piece: Piece, shown = frame.loaded): number {
  writeDensity(factor, 0, frame, piece, shown);
  return factor[0]!;
}

const factor = new Float32Array(1);

/** The same, written to a place: a number that is given back would be boxed. */
export function writeDensity(
  out: Float32Array,
  at: number,
  frame: CloudFrame,
  piece: Piece,
  shown: number,
): void {
  out[at] = Math.sqrt(Math.min(1, pointsOfLevel(frame, piece.level) / Math.max(1, shown)));
}

function pointsOfLevel({ pieces }: CloudFrame, level: number): number {
  let points = 0;
  for (let i = 0; i < pieces.length; i++) {
    if (pieces[i]!.level === level) points += pieces[i]!.count;
  }
  return points;
}

/**
 * More points than any frame has: no limit.  A small integer, where `Infinity` would be boxed for each
 * that takes it.
 */
export const ALL_POINTS = 2 ** 30 - 1;

/** Points of the finest levels that together have at most `limit`; the first level always. */
export function pointsWithin(frame: CloudFrame, limit: number): number {
  const { pieces } = frame;
  let points = 0;
  for (let i = 0; i < pieces.length; i++) {
    const { level, first, count } = pieces[i]!;
    if (pieces[i + 1]?.level === level) continue;
    if (points > 0 && first + count > limit) break;
    points = first + count;
  }
  return points;
}
