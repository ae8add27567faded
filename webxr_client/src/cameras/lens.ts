/** A camera's lens by the models of OpenCV and ROS, as in the server's `masks/views.py`. */
import type { Camera } from '../protocol/values';

type Vec = readonly [number, number, number];

const FISHEYE = ['equidistant', 'fisheye', 'kannala_brandt4'];
const POLYNOMIAL = ['', 'plumb_bob', 'rational_polynomial', 'radtan'];
/** Least depth of a point in the picture, metres. */
const NEAREST = 0.05;
/** Number of parts that a line is drawn in. */
const LINE_STEPS = 16;

export class Lens {
  /** Last projected place: column and row, pixels, and depth, metres. */
  readonly at = new Float64Array(3);
  private readonly rows: Float64Array;
  private readonly k: Float64Array;
  private readonly fisheye: boolean;
  /** Squared radius up to which the distortion grows, in focal lengths. */
  private readonly reach: number;

  private constructor(
    readonly picture: Camera,
    K: readonly (readonly number[])[],
    T: readonly (readonly number[])[],
    shift: Vec,
  ) {
    this.k = Float64Array.of(K[0]![0]!, K[0]![1]!, K[0]![2]!, K[1]![1]!, K[1]![2]!);
    this.rows = new Float64Array(12);
    for (let row = 0; row < 3; row++) {
      for (let k = 0; k < 3; k++) this.rows[row * 4 + k] = T[row]![k]!;
      const moved = [0, 1, 2].reduce((sum, k) => sum + T[row]![k]! * shift[k]!, 0);
      this.rows[row * 4 + 3] = T[row]![3]! + moved;
    }
    this.fisheye = FISHEYE.includes(picture.model);
    this.reach = this.fisheye ? Infinity : this.unfolded();
  }

  /** Return the lens of a picture; null if its calibration or model is unknown. */
  static of(picture: Camera, shift: Vec): Lens | null {
    const { K, T_camera_frame: T, model } = picture;
    const known = FISHEYE.includes(model) || POLYNOMIAL.includes(model);
    if (!K || !T || (!known && picture.distortion.some((k) => k !== 0))) return null;
    return new Lens(picture, K, T, shift);
  }

  /** Project a place (local metres) to `at`; return whether it is in the picture. */
  project(x: number, y: number, z: number): boolean {
    const { rows, at, k, picture } = this;
    const depth = rows[8]! * x + rows[9]! * y + rows[10]! * z + rows[11]!;
    if (depth < NEAREST) return false;
    at[0] = (rows[0]! * x + rows[1]! * y + rows[2]! * z + rows[3]!) / depth;
    at[1] = (rows[4]! * x + rows[5]! * y + rows[6]! * z + rows[7]!) / depth;
    if (at[0] * at[0] + at[1] * at[1] > this.reach) return false;
    this.distort();
    const u = k[0]! * at[0] + k[1]! * at[1] + k[2]!;
    const v = k[3]! * at[1] + k[4]!;
    at[0] = u;
    at[1] = v;
    at[2] = depth;
    return u >= 0 && v >= 0 && u < picture.width && v < picture.height;
  }

  /** Return the SVG path of lines, bent as in the picture; `ends`: pairs of ends, local metres. */
  lines(ends: readonly number[]): string {
    let path = '';
    for (let line = 0; line < ends.length; line += 6) {
      let drawn = false;
      for (let step = 0; step <= LINE_STEPS; step++) {
        const share = step / LINE_STEPS;
        const along = (k: number): number =>
          ends[line + k]! + share * (ends[line + 3 + k]! - ends[line + k]!);
        // A line that leaves the picture continues where it enters again.
        const seen = this.project(along(0), along(1), along(2));
        if (seen) path += `${drawn ? 'L' : 'M'}${this.at[0]!.toFixed(1)} ${this.at[1]!.toFixed(1)}`;
        drawn = seen;
      }
    }
    return path;
  }

  /** Distort the place in `at`, at a depth of 1. */
  private distort(): void {
    const { at } = this;
    const d = this.picture.distortion;
    if (d.length === 0) return;
    const [x, y] = [at[0]!, at[1]!];
    const r2 = x * x + y * y;
    if (this.fisheye) {
      const r = Math.sqrt(r2);
      const angle = Math.atan(r);
      const a2 = angle * angle;
      const bent = angle * (1 + a2 * (c(d, 0) + a2 * (c(d, 1) + a2 * (c(d, 2) + a2 * c(d, 3)))));
      const scale = r < 1e-9 ? 1 : bent / r;
      at[0] = x * scale;
      at[1] = y * scale;
      return;
    }
    const radial = radialAt(d, r2);
    at[0] = x * radial + 2 * c(d, 2) * x * y + c(d, 3) * (r2 + 2 * x * x);
    at[1] = y * radial + c(d, 2) * (r2 + 2 * y * y) + 2 * c(d, 3) * x * y;
  }

  /** Return the squared radius up to which the distortion grows, in focal lengths. */
  private unfolded(): number {
    const d = this.picture.distortion;
    for (let r = 0.05; r < 5; r += 0.05) {
      const before = (r - 0.05) * radialAt(d, (r - 0.05) ** 2);
      if (r * radialAt(d, r * r) <= before) return (r - 0.05) ** 2;
    }
    return Infinity;
  }

  /** Position of the camera, local metres. */
  get eye(): [number, number, number] {
    const { rows } = this;
    const along = (k: 0 | 1 | 2): number =>
      -(rows[k]! * rows[3]! + rows[4 + k]! * rows[7]! + rows[8 + k]! * rows[11]!);
    return [along(0), along(1), along(2)];
  }
}

/** Return a coefficient, 0 if the camera has fewer. */
function c(d: readonly number[], k: number): number {
  return d[k] ?? 0;
}

/** Return k1 to k3 over k4 to k6; the order is k1, k2, p1, p2, k3, k4, k5, k6. */
function radialAt(d: readonly number[], r2: number): number {
  const above = 1 + r2 * (c(d, 0) + r2 * (c(d, 1) + r2 * c(d, 4)));
  return above / (1 + r2 * (c(d, 5) + r2 * (c(d, 6) + r2 * c(d, 7))));
}
