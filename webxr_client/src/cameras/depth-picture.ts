/** The picture of a depth camera, from the colours and depths of its pixels. */
import { sidesOf } from '../net/depth/grid';
import type { DepthImage } from '../net/chunk/segment';
import type { Lattice } from '../protocol/messages';
import type { Camera } from '../protocol/values';
import type { Vec } from '../store/types';

/** The server's name of the depth camera. */
const NAME = 'depth';
/** Grey of the nearest and the farthest pixel without a colour. */
const [NEAREST, FARTHEST] = [235, 60];

/** The depth camera as the server describes cameras; `shift`: source minus local coordinates. */
export function depthCamera(lattice: Lattice, shift: Vec): Camera {
  const { width, height, axis, sign, eye, tangent, pitch } = lattice;
  const [a, b] = sidesOf(lattice);
  const row = (side: number, factor: number): number[] => {
    const along = [0, 1, 2].map((k) => (k === side ? factor : 0));
    return [...along, -factor * (eye[side]! + shift[side]!)];
  };
  return {
    name: NAME,
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

/** Draw the pixels that have come, in their colours or else by their depth. */
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

/** Write the colour of a pixel: see `Colours`. */
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
