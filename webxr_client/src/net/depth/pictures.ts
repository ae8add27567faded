/** JPEG → pixels, by the browser's own decoder, which works in a separate thread. */
import type { Colours } from '../chunk/segment';

const JPEG = 'image/jpeg';
const PIXEL_BYTES = 4;

/** The bytes of a picture, and where in them its colours are. */
export type Pixels = Pick<Colours, 'bytes' | 'planes' | 'luma'>;
/** Gives memory of at least so many bytes. */
export type Allocate = (bytes: number) => ArrayBuffer;

/** A picture that has been decoded, until it is closed. */
export interface Picture {
  readonly width: number;
  readonly height: number;
  read(allocate: Allocate): Promise<Pixels>;
  close(): void;
}

export type ReadPicture = (jpeg: Uint8Array<ArrayBuffer>) => Promise<Picture>;

export const readPicture: ReadPicture = async (jpeg) => {
  if (typeof ImageDecoder === 'undefined') {
    const blob = new Blob([jpeg], { type: JPEG });
    return new Drawn(await createImageBitmap(blob, { colorSpaceConversion: 'none' }));
  }
  // Neither a blob, which another process keeps, nor a canvas to be read back.
  const decoder = new ImageDecoder({ data: jpeg, type: JPEG, colorSpaceConversion: 'none' });
  try {
    const { image } = await decoder.decode();
    const shared = subsampling(image);
    return shared ? new Planar(image, shared) : new Drawn(image);
  } finally {
    decoder.close();
  }
};

/** Pixels that share a chroma, to the right and down, in a decoder's own format. */
const SUBSAMPLING: Record<string, readonly [number, number]> = {
  I420: [2, 2],
  I422: [2, 1],
  I444: [1, 1],
};

/** Null for planes unlike a JPEG's: then the picture is drawn and read back. */
function subsampling({ format, colorSpace }: VideoFrame): readonly [number, number] | null {
  const { fullRange, matrix } = colorSpace;
  return (fullRange && matrix === 'smpte170m' && SUBSAMPLING[format ?? '']) || null;
}

class Planar implements Picture {
  readonly width: number;
  readonly height: number;

  constructor(
    private readonly image: VideoFrame,
    private readonly shared: readonly [number, number],
  ) {
    this.width = image.displayWidth;
    this.height = image.displayHeight;
  }

  async read(allocate: Allocate): Promise<Pixels> {
    const { image, shared } = this;
    const size = image.allocationSize();
    const bytes = new Uint8Array(allocate(size), 0, size);
    const layouts = await image.copyTo(bytes);
    const planes = layouts.flatMap(({ offset, stride }, plane) => {
      const [across, down] = plane === 0 ? [1, 1] : shared;
      return [offset, stride, across + 16 * down, 1];
    });
    return { bytes, planes: Int32Array.from(planes), luma: true };
  }

  close(): void {
    this.image.close();
  }
}

/** Bytes of red, green, blue and a spare one. */
function interleaved(bytes: Uint8Array<ArrayBuffer>, stride: number): Pixels {
  const planes = [0, 1, 2].flatMap((offset) => [offset, stride, 1 + 16, PIXEL_BYTES]);
  return { bytes, planes: Int32Array.from(planes), luma: false };
}

let canvas: OffscreenCanvas | null = null;
let context: OffscreenCanvasRenderingContext2D | null = null;

/** Decode by drawing on a canvas and reading back, where there is nothing better. */
class Drawn implements Picture {
  readonly width: number;
  readonly height: number;

  constructor(private readonly image: ImageBitmap | VideoFrame) {
    const bitmap = image instanceof ImageBitmap;
    this.width = bitmap ? image.width : image.displayWidth;
    this.height = bitmap ? image.height : image.displayHeight;
  }

  read(allocate: Allocate): Promise<Pixels> {
    const { width, height } = this;
    if (canvas?.width !== width || canvas.height !== height) {
      canvas = new OffscreenCanvas(width, height);
      context = canvas.getContext('2d', { alpha: false, willReadFrequently: true });
    }
    if (!context) throw new Error('This browser has no 2D canvas in workers.');
    context.drawImage(this.image, 0, 0);
    const { data } = context.getImageData(0, 0, width, height);
    const bytes = new Uint8Array(allocate(data.length), 0, data.length);
    bytes.set(data);
    return Promise.resolve(interleaved(bytes, PIXEL_BYTES * width));
  }

  close(): void {
    this.image.close();
  }
}
