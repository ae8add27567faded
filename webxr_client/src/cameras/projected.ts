/** A frame's points in a picture: the nearest point at each pixel of a raster, in its label's colour. */
import type { CloudFrame } from '../cloud/points/frame';
import { DELETED } from '../cloud/points/piece';
import type { Rgb } from '../common/colors';
import type { Lens } from './lens';

/** Most points of a frame that are drawn: of the coarse levels, which are an even subsample. */
export const MOST = 60_000;
/** Opacity, of 255, of points with a label, and the usual one of points without. */
const LABELLED = 235;
export const UNLABELLED = 70;

/** An outline: dots at the points minus smaller dots; diameters are shares of the picture's width. */
const RINGS = [
  [1 / 40, '#0b0e12', 'source-over'],
  [1 / 50, '#ffffff', 'source-over'],
  [1 / 80, '#000000', 'destination-out'],
] as const;
/** Length of the line that draws a dot, pixels; browsers omit lines without length. */
const DOT = 0.01;

/** Colour of a label, 0 to 255 each; null if its points are hidden. */
export type ColourOf = (label: number) => Rgb | null;

export class Projected {
  readonly pixels: ImageData;
  /** Stored number of the point at each pixel, −1 without one. */
  readonly points: Int32Array;
  private readonly depths: Float32Array;

  constructor(
    readonly width: number,
    readonly height: number,
    private readonly unlabelled = UNLABELLED,
  ) {
    this.pixels = new ImageData(width, height);
    this.points = new Int32Array(width * height);
    this.depths = new Float32Array(width * height);
  }

  /** Draw a frame's points; labelled points are two pixels wide. */
  draw(frame: CloudFrame, lens: Lens, colourOf: ColourOf): void {
    this.pixels.data.fill(0);
    this.points.fill(-1);
    this.depths.fill(Infinity);
    const { at, picture } = lens;
    const [sx, sy] = [this.width / picture.width, this.height / picture.height];
    let count = 0;
    for (const piece of frame.pieces) {
      if (count > MOST) break;
      const { words, origin, scale } = piece;
      for (let i = 0, w = 0; i < piece.count; i++, w += 6) {
        const label = frame.labelOf(piece.first + i);
        const colour = label === DELETED ? null : colourOf(label);
        if (!colour) continue;
        const x = origin[0] + words[w]! * scale[0];
        const y = origin[1] + words[w + 1]! * scale[1];
        const z = origin[2] + words[w + 2]! * scale[2];
        if (!lens.project(x, y, z)) continue;
        const [u, v] = [Math.floor(at[0]! * sx), Math.floor(at[1]! * sy)];
        for (let k = 0; k < (label === 0 ? 1 : 4); k++)
          this.put(u + (k & 1), v + (k >> 1), at[2]!, piece.first + i, colour, label);
      }
      count += piece.count;
    }
  }

  /** Draw the edge of some of a frame's points over the picture; `points`: stored numbers. */
  outline(pen: CanvasRenderingContext2D, frame: CloudFrame, lens: Lens, points: Uint32Array): void {
    const share = this.width / lens.picture.width;
    pen.lineCap = 'round';
    for (const [width, colour, how] of RINGS) {
      Object.assign(pen, { lineWidth: width * this.width, strokeStyle: colour, globalCompositeOperation: how }); // prettier-ignore
      pen.beginPath();
      for (const point of points) {
        const place = placeOf(frame, point);
        if (!place || !lens.project(...place)) continue;
        const [u, v] = [lens.at[0]! * share, lens.at[1]! * share];
        pen.moveTo(u, v);
        pen.lineTo(u + DOT, v);
      }
      pen.stroke();
    }
  }

  /** Draw a pixel of a point if no drawn one is nearer. */
  private put(
    u: number,
    v: number,
    depth: number,
    point: number,
    colour: Rgb,
    label: number,
  ): void {
    if (u >= this.width || v >= this.height) return;
    const pixel = v * this.width + u;
    if (depth >= this.depths[pixel]!) return;
    this.depths[pixel] = depth;
    this.points[pixel] = point;
    const { data } = this.pixels;
    for (let k = 0; k < 3; k++) data[pixel * 4 + k] = colour[k]!;
    data[pixel * 4 + 3] = label === 0 ? this.unlabelled : LABELLED;
  }

  /** Return the drawn point nearest to a pixel, at most `reach` pixels away; −1 without one. */
  nearest(u: number, v: number, reach: number): number {
    let best = reach * reach + 1;
    let found = -1;
    for (let y = Math.max(0, v - reach); y <= Math.min(this.height - 1, v + reach); y++) {
      for (let x = Math.max(0, u - reach); x <= Math.min(this.width - 1, u + reach); x++) {
        const squaredDistance = (x - u) ** 2 + (y - v) ** 2;
        if (squaredDistance >= best || this.points[y * this.width + x]! < 0) continue;
        best = squaredDistance;
        found = this.points[y * this.width + x]!;
      }
    }
    return found;
  }
}

/** Return the position of a frame's point, local metres; null if it is not loaded. */
export function placeOf(frame: CloudFrame, point: number): [number, number, number] | null {
  const piece = frame.pieceOf(point);
  if (!piece) return null;
  const w = (point - piece.first) * 6;
  const at = (k: 0 | 1 | 2): number => piece.origin[k] + piece.words[w + k]! * piece.scale[k];
  return [at(0), at(1), at(2)];
}
