/** JPEG → pixels, by the browser's own decoder, which works in a thread of its own. */

const JPEG = 'image/jpeg';
export const PIXEL_BYTES = 4;

/** A picture that has been decoded, until it is closed. */
export interface Picture {
  readonly width: number;
  readonly height: number;
  /** Write red, green, blue and a spare byte of each pixel, row by row. */
  copyTo(target: Uint8Array<ArrayBuffer>): Promise<void>;
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
    return converts(image) ? new Converted(image) : new Drawn(image);
  } finally {
    decoder.close();
  }
};

/** Whether this browser's frames turn into RGB: some take no notice of the format, or refuse it. */
function converts(image: VideoFrame): boolean {
  const { displayWidth, displayHeight } = image;
  try {
    return image.allocationSize({ format: 'RGBX' }) === PIXEL_BYTES * displayWidth * displayHeight;
  } catch {
    return false;
  }
}

class Converted implements Picture {
  readonly width: number;
  readonly height: number;

  constructor(private readonly image: VideoFrame) {
    this.width = image.displayWidth;
    this.height = image.displayHeight;
  }

  async copyTo(target: Uint8Array<ArrayBuffer>): Promise<void> {
    await this.image.copyTo(target, { format: 'RGBX' });
  }

  close(): void {
    this.image.close();
  }
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

  copyTo(target: Uint8Array<ArrayBuffer>): Promise<void> {
    const { width, height } = this;
    if (canvas?.width !== width || canvas.height !== height) {
      canvas = new OffscreenCanvas(width, height);
      context = canvas.getContext('2d', { alpha: false, willReadFrequently: true });
    }
    if (!context) throw new Error('This browser has no 2D canvas in workers.');
    context.drawImage(this.image, 0, 0);
    target.set(context.getImageData(0, 0, width, height).data);
    return Promise.resolve();
  }

  close(): void {
    this.image.close();
  }
}
