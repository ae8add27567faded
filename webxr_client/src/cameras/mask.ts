/** Mask of a picture that is painted by a brush or an outline, and its file. */

/** Bytes of a `.npy` file before its pixels. */
const NPY_HEAD = 128;

/** Column and row in a picture, pixels; the centre of the first pixel is at 0.5, 0.5. */
export type Place = readonly [u: number, v: number];

export class PaintedMask {
  /** 1 at painted pixels, row by row. */
  readonly pixels: Uint8Array<ArrayBuffer>;

  constructor(
    readonly width: number,
    readonly height: number,
  ) {
    this.pixels = new Uint8Array(width * height);
  }

  /** Paint the pixels with centres within `radius`, pixels, of a path. */
  brush(path: readonly Place[], radius: number): void {
    path.forEach((end, i) => this.sweep(path[Math.max(0, i - 1)]!, end, radius));
  }

  /** Paint the pixels with centres within `radius`, pixels, of a line. */
  private sweep([u, v]: Place, [endU, endV]: Place, radius: number): void {
    const [du, dv] = [endU - u, endV - v];
    const squaredLength = du * du + dv * dv || 1;
    const [top, bottom] = within(Math.min(v, endV) - radius, Math.max(v, endV) + radius, this.height); // prettier-ignore
    const [left, right] = within(Math.min(u, endU) - radius, Math.max(u, endU) + radius, this.width); // prettier-ignore
    for (let row = top; row < bottom; row++) {
      for (let column = left; column < right; column++) {
        const [x, y] = [column + 0.5 - u, row + 0.5 - v];
        const along = Math.min(1, Math.max(0, (x * du + y * dv) / squaredLength));
        const squaredDistance = (x - along * du) ** 2 + (y - along * dv) ** 2;
        if (squaredDistance <= radius * radius) this.pixels[row * this.width + column] = 1;
      }
    }
  }

  /** Paint the pixels with centres inside a polygon, by the even-odd rule. */
  polygon(corners: readonly Place[]): void {
    for (let row = 0; row < this.height; row++) {
      const crossings = crossingsOf(corners, row + 0.5);
      for (let k = 0; k + 1 < crossings.length; k += 2) {
        const [left, right] = within(crossings[k]!, crossings[k + 1]!, this.width);
        this.pixels.fill(1, row * this.width + left, row * this.width + right);
      }
    }
  }

  /** Return the mask as a `.npy` file (NumPy format 1.0). */
  npy(): Blob {
    const header = `{'descr': '|u1', 'fortran_order': False, 'shape': (${this.height}, ${this.width}), }`;
    const head = `${header.padEnd(NPY_HEAD - 11)}\n`;
    const magic = Uint8Array.of(0x93, 78, 85, 77, 80, 89, 1, 0, head.length, 0);
    return new Blob([magic, head, this.pixels], { type: 'application/x-npy' });
  }
}

/** Return the range of the pixels with centres in an interval; `stop` is excluded. */
function within(low: number, high: number, size: number): [first: number, stop: number] {
  return [Math.max(0, Math.ceil(low - 0.5)), Math.min(size, Math.floor(high - 0.5) + 1)];
}

/** Return the columns at which the sides of a polygon cross a row, ascending. */
function crossingsOf(corners: readonly Place[], v: number): number[] {
  const found: number[] = [];
  corners.forEach(([u, top], i) => {
    const [endU, bottom] = corners[(i + 1) % corners.length]!;
    if (top <= v !== bottom <= v) found.push(u + ((v - top) / (bottom - top)) * (endU - u));
  });
  return found.sort((one, other) => one - other);
}
