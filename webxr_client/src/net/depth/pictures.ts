/** JPEG → pixels, by the browser's own decoder, which works in a thread of its own. */

export interface Picture {
  /** Red, green and blue in the three lowest bytes, row by row. */
  readonly pixels: Uint32Array;
  readonly width: number;
}

export type ReadPicture = (jpeg: Uint8Array<ArrayBuffer>) => Promise<Picture>;

let canvas: OffscreenCanvas | null = null;
let context: OffscreenCanvasRenderingContext2D | null = null;

export const readPicture: ReadPicture = async (jpeg) => {
  const blob = new Blob([jpeg], { type: 'image/jpeg' });
  const bitmap = await createImageBitmap(blob, { colorSpaceConversion: 'none' });
  const { width, height } = bitmap;
  if (canvas?.width !== width || canvas.height !== height) {
    canvas = new OffscreenCanvas(width, height);
    context = canvas.getContext('2d', { alpha: false, willReadFrequently: true });
  }
  if (!context) throw new Error('This browser gives no 2D canvas to a worker.');
  context.drawImage(bitmap, 0, 0);
  bitmap.close();
  const { data } = context.getImageData(0, 0, width, height);
  return { pixels: new Uint32Array(data.buffer, data.byteOffset, width * height), width };
};
