/** A depth image, its picture and its labels as textures, with a texel for each pixel. */
import { DataTexture, NearestFilter, RedFormat, RedIntegerFormat, UnsignedByteType, UnsignedShortType, Vector2 } from 'three'; // prettier-ignore
import type { Matrix4, PixelFormat, TextureDataType, WebGLRenderer } from 'three';
import type { Colours } from '../../net/chunk/segment';
import type { Lattice } from '../../protocol/messages';
import type { CloudFrame } from '../points/frame';
import { normalColours } from '../points/normals';
import { lowerBound, type Piece } from '../points/piece';

/** Bytes of a pixel in the widest pictures: red, green, blue and a spare one. */
const MOST_BYTES = 4;
const NO_PLANES = new Int32Array(12);

export class LatticeTextures {
  readonly uniforms;
  /** Labels of the server by pixel, and as they are shown. */
  private readonly stored: Uint16Array<ArrayBuffer>;
  private readonly shown: Uint16Array<ArrayBuffer>;
  /** Of each piece that is in `stored`. */
  private readonly versions = new Map<Piece, number>();
  private blank = false;

  constructor(
    private readonly renderer: WebGLRenderer,
    private readonly lattice: Lattice,
  ) {
    const { width, height } = lattice;
    this.stored = new Uint16Array(width * height);
    this.shown = new Uint16Array(width * height);
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
  writeImage(frame: CloudFrame, normals: Matrix4 | null): void {
    const { depths, colours } = frame.image!;
    const { width, height } = this.lattice;
    this.write(this.uniforms.depths.value, depths, height);
    const shown = normals ? normalPicture(frame, normals) : colours;
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

  /** Bring over the labels as shown. */
  writeLabels(frame: CloudFrame): void {
    const { shown } = this;
    const plain = frame.blank && frame.predicted === null;
    if (plain && this.blank) return;
    this.blank = plain;
    if (plain) {
      this.forget();
      shown.fill(0);
    } else {
      this.store(frame);
      shown.set(this.stored);
      this.showOverlays(frame);
    }
    this.write(this.uniforms.labels.value, shown, this.lattice.height);
  }

  private forget(): void {
    this.versions.clear();
    this.stored.fill(0);
  }

  /** Write the server's labels of the pieces whose labels changed. */
  private store({ pieces }: CloudFrame): void {
    const { stored, versions } = this;
    // Another frame has points at other pixels.
    if (versions.size > 0 && !versions.has(pieces[0]!)) this.forget();
    for (let i = 0; i < pieces.length; i++) {
      const piece = pieces[i]!;
      const { labels, pixels, labelsVersion } = piece;
      if (versions.get(piece) === labelsVersion) continue;
      versions.set(piece, labelsVersion);
      if (labels) for (let k = 0; k < labels.length; k++) stored[pixels![k]!] = labels[k]!;
    }
  }

  private showOverlays(frame: CloudFrame): void {
    const { shown } = this;
    const { pieces, overlays, predicted } = frame;
    for (const { indices, values } of overlays.values()) {
      const single = values.length === 1;
      let at = 0;
      for (let i = 0; i < pieces.length; i++) {
        const { first, count, pixels } = pieces[i]!;
        const stop = lowerBound(indices, first + count);
        for (; at < stop; at++) shown[pixels![indices[at]! - first]!] = values[single ? 0 : at]!;
      }
    }
    if (!predicted) return;
    for (let i = 0; i < pieces.length; i++) {
      const { first, count, pixels } = pieces[i]!;
      const labels = Uint16Array.from(pixels!, (pixel) => shown[pixel]!);
      frame.fillPredicted(labels, first, count);
      for (let k = 0; k < count; k++) shown[pixels![k]!] = labels[k]!;
    }
  }

  /** Label of a point as last brought over. */
  labelAt(frame: CloudFrame, number: number): number {
    const piece = frame.pieceOf(number)!;
    return this.shown[piece.pixels![number - piece.first]!]!;
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
function normalPicture({ pieces, image }: CloudFrame, room: Matrix4): Colours {
  const { width, height } = image!.lattice;
  const bytes = new Uint8Array(MOST_BYTES * width * height);
  const colours = normalColours(pieces, room);
  let i = 0;
  for (const { pixels } of pieces) {
    for (const pixel of pixels!) {
      for (let k = 0; k < 3; k++) bytes[MOST_BYTES * pixel + k] = colours[i++]!;
    }
  }
  const planes = [0, 1, 2].flatMap((k) => [k, MOST_BYTES * width, 1 + 16, MOST_BYTES]);
  return { bytes, planes: Int32Array.from(planes), luma: false, step: 1 };
}
