/** Draws the picture of a depth camera from the colours and depths of its pixels. */
import { Matrix4 } from 'three';
import { sidesOf } from '../net/depth/grid';
import type { DepthImage } from '../net/chunk/segment';
import type { SequenceInfo } from '../protocol/messages';
import type { Camera } from '../protocol/values';

/** Name of the only depth camera, and start of the names of several, as in the server's `masks/views.py`. */
const NAME = 'depth';
/** Grey, of 255, of the nearest and the farthest pixel of an image without colours. */
const [NEAREST, FARTHEST] = [235, 60];

/** Return the camera of a depth image as a `Camera`. */
export function depthCamera(
  { sensor, lattice, mount }: Pick<DepthImage, 'sensor' | 'lattice' | 'mount'>,
  { shift, sensors }: Pick<SequenceInfo, 'shift' | 'sensors'>,
): Camera {
  const { width, height, axis, sign, eye, tangent, pitch } = lattice;
  const [a, b] = sidesOf(lattice);
  const T = new Matrix4().makeTranslation(-shift[0], -shift[1], -shift[2]);
  if (mount) T.premultiply(new Matrix4().set(...(mount as Parameters<Matrix4['set']>)).invert());
  const row = (side: number, factor: number): number[] =>
    [0, 1, 2, 3].map((k) => factor * (T.elements[4 * k + side]! - (k === 3 ? eye[side]! : 0)));
  return {
    name: sensors[sensor] ? `${NAME}-${sensors[sensor].name}` : NAME,
    width,
    height,
    // Lines through the middles of pixels meet whole columns and rows of the lattice.
    K: [
      [1 / pitch[0], 0, 0.5 - tangent[0] / pitch[0]],
      [0, 1 / pitch[1], 0.5 - tangent[1] / pitch[1]],
      [0, 0, 1],
    ],
    distortion: [],
    model: '',
    T_camera_frame: [row(a, 1), row(b, 1), row(axis, sign), [0, 0, 0, 1]],
  };
}

/** Draw the pixels of an image in their colours, or without colours in greys by depth. */
export function drawDepth({ lattice, depths, colours }: DepthImage, into: ImageData): void {
  const { data } = into;
  const farthest = colours ? 1 : depths.reduce((most, depth) => Math.max(most, depth), 1);
  for (let pixel = 0; pixel < depths.length; pixel++) {
    const [at, depth] = [4 * pixel, depths[pixel]!];
    const [column, row] = [pixel % lattice.width, Math.floor(pixel / lattice.width)];
    if (colours) writeColour(colours, column, row, data, at);
    else data.fill(NEAREST + ((FARTHEST - NEAREST) * depth) / farthest, at, at + 3);
    data[at + 3] = colours || depth > 0 ? 255 : 0;
  }
}

/** Write the red, green and blue of a pixel to `out`, from `to` on; see `Colours`. */
function writeColour(
  { bytes, planes, luma, step }: NonNullable<DepthImage['colours']>,
  column: number,
  row: number,
  out: Uint8ClampedArray,
  to: number,
): void {
  const [x, y] = [Math.floor(column / step), Math.floor(row / step)];
  for (let plane = 0; plane < 3; plane++) {
    const share = planes[4 * plane + 2]!;
    const [down, across] = [Math.floor(y / (share >> 4)), Math.floor(x / (share & 15))];
    out[to + plane] = bytes[planes[4 * plane]! + down * planes[4 * plane + 1]! + across * planes[4 * plane + 3]!]!; // prettier-ignore
  }
  if (!luma) return;
  // JFIF: luma, then the two chromas around 128.
  const [light, cb, cr] = [out[to]!, out[to + 1]! - 128, out[to + 2]! - 128];
  out[to] = light + 1.402 * cr;
  out[to + 1] = light - 0.344136 * cb - 0.714136 * cr;
  out[to + 2] = light + 1.772 * cb;
}
