/** A depth image, its picture and its labels as textures, with a texel for each pixel. */
import { DataTexture, NearestFilter, RedFormat, RedIntegerFormat, UnsignedByteType, UnsignedShortType, Vector2 } from 'three'; // prettier-ignore
import type { Matrix4, PixelFormat, TextureDataType, WebGLRenderer } from 'three';
import type { Colours, DepthImage } from '../../../net/chunk/segment';
import type { Lattice } from '../../../protocol/messages';
import type { CloudFrame } from '../../points/frame';
import { raysOf } from '../../../net/depth/grid';
import { normalColours } from '../../points/normals';

/** Bytes of a pixel in the widest pictures: red, green, blue and a spare one. */
const MOST_BYTES = 4;
const NO_PLANES = new Int32Array(12);

export class LatticeTextures {
  readonly uniforms;
  /** Labels by pixel. */
  private readonly labels: Uint16Array<ArrayBuffer>;

  constructor(
    private readonly renderer: WebGLRenderer,
    private readonly lattice: Lattice,
  ) {
    const { width, height } = lattice;
    this.labels = new Uint16Array(width * height);
    const rows = MOST_BYTES * height;
    this.uniforms = {
      depths: { value: texture(width, height, RedIntegerFormat, UnsignedShortType) },
      labels: { value: texture(width, height, RedIntegerFormat, UnsignedShortType) },
      colours: { value: texture(width, rows, RedFormat, UnsignedByteType) },
      planes: { value: NO_PLANES as Int32Array },
      picture: { value: new Vector2() },
    };
    this.write(this.uniforms.colours.value, new Uint8Array(width * rows), rows);
  }

  /** Bring over depths and colours, or normals in their place. */
  writeImage(frame: CloudFrame, image: DepthImage, normals: Matrix4 | null): void {
    const { depths, colours } = image;
    const { width, height } = this.lattice;
    this.write(this.uniforms.depths.value, depths, height);
    const shown = normals ? normalPicture(frame, image, normals) : colours;
    this.uniforms.planes.value = shown?.planes ?? NO_PLANES;
    this.uniforms.picture.value.set(shown?.step ?? 0, shown?.luma ? 1 : 0);
    if (!shown) return;
    const rows = Math.ceil(shown.bytes.length / width);
    const bytes = new Uint8Array(shown.bytes.buffer, 0, rows * width);
    this.write(this.uniforms.colours.value, bytes, rows);
  }

  private write(
    to: DataTexture,
    data: Uint8Array<ArrayBuffer> | Uint16Array<ArrayBuffer>,
    rows: number,
  ): void {
    to.image.data = data;
    to.image.height = rows;
    to.needsUpdate = true;
    this.renderer.initTexture(to);
  }

  /** Bring over labels in stored order; `plain`: there are none. */
  writeLabels({ pieces }: CloudFrame, sensor: number, stored: Uint16Array, plain: boolean): void {
    const { labels } = this;
    if (plain) labels.fill(0);
    for (let i = 0; i < pieces.length && !plain; i++) {
      if (pieces[i]!.sensor !== sensor) continue;
      const { first, count, pixels } = pieces[i]!;
      for (let k = 0; k < count; k++) labels[pixels![k]!] = stored[first + k]!;
    }
    this.write(this.uniforms.labels.value, labels, this.lattice.height);
  }

  dispose(): void {
    const { depths, labels, colours } = this.uniforms;
    for (const { value } of [depths, labels, colours]) value.dispose();
  }
}

function texture(
  width: number,
  height: number,
  format: PixelFormat,
  type: TextureDataType,
): DataTexture {
  const made = new DataTexture(null, width, height, format, type);
  made.minFilter = made.magFilter = NearestFilter;
  return made;
}

/** Colours of the directions of a frame's surfaces. */
function normalPicture(frame: CloudFrame, image: DepthImage, room: Matrix4): Colours {
  const { width, height } = image.lattice;
  const bytes = new Uint8Array(MOST_BYTES * width * height);
  const pieces = frame.pieces.filter(({ sensor }) => sensor === image.sensor);
  const rays = raysOf(image);
  const colours = normalColours(pieces, room, [rays[0]!, rays[4]!, rays[8]!]);
  let i = 0;
  for (const { pixels } of pieces) {
    for (const pixel of pixels!) {
      for (let k = 0; k < 3; k++) bytes[MOST_BYTES * pixel + k] = colours[i++]!;
    }
  }
  const planes = [0, 1, 2].flatMap((k) => [k, MOST_BYTES * width, 1 + 16, MOST_BYTES]);
  return { bytes, planes: Int32Array.from(planes), luma: false, step: 1 };
}
