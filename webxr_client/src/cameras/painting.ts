/** Painting in a picture: a brush or an outline makes a mask, which labels the points behind it. */
import { signal } from '@preact/signals';
import { attempt, sequencePath } from '../engine/recordings/recordings';
import { api } from '../net/rest';
import type { Camera, MaskEdit } from '../protocol/values';
import { actions } from '../store/actions';
import { isStroke, notify, state } from '../store/state';
import { brushColor, refusal } from '../tools/brush';
import { LassoOutline } from '../tools/lasso';
import { PaintedMask, type Place } from './mask';
import { pictures } from './state';

export type PictureTool = 'choose' | 'brush' | 'polygon' | 'rectangle';

/** Tool of the mouse button in the large picture. */
export const pictureTool = signal<PictureTool>('choose');
/** Radius of the brush, as a share of the picture's width. */
export const pictureBrush = signal(0.02);
/** Opacity of the painted pixels before they are sent. */
const INK = 0.55;

const OTHER_TOOL = 'In a picture you can paint and erase. Choose one of these tools.';

/** The painter that keys act on; null: no large picture is open. */
let painter: PicturePainter | null = null;

export const pictureKeys = {
  cancel: () => painter?.cancel() ?? false,
  close: () => painter?.close() ?? false,
  takeBack: () => painter?.takeBack() ?? false,
};

/** Return a painter of the large picture, which keys then act on. */
export function openPainter(canvas: HTMLCanvasElement, picture: Camera): PicturePainter {
  painter = new PicturePainter(canvas, picture);
  return painter;
}

export class PicturePainter {
  private readonly outline: LassoOutline;
  /** Path of the pressed brush, pixels of the picture. */
  private path: Place[] = [];
  private pressed = false;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly picture: Camera,
  ) {
    this.outline = new LassoOutline(canvas);
  }

  dispose(): void {
    this.cancel();
    if (painter === this) painter = null;
  }

  press(event: PointerEvent): void {
    const tool = pictureTool.peek();
    if (event.button !== 0 || tool === 'choose') return;
    const reason = refusalInPicture();
    if (reason) {
      notify('info', ...reason);
      return;
    }
    if (state.playing.peek()) actions.time.pause();
    const [x, y] = [event.offsetX, event.offsetY];
    if (this.outline.open) {
      if (this.outline.corner(x, y)) this.close();
      return;
    }
    this.pressed = tool !== 'polygon';
    if (this.pressed) this.canvas.setPointerCapture(event.pointerId);
    if (tool !== 'brush') this.outline.begin(x, y, brushColor(), tool);
    else this.extend(x, y);
  }

  move({ offsetX, offsetY }: PointerEvent): void {
    if (this.path.length > 0) this.extend(offsetX, offsetY);
    else this.outline.add(offsetX, offsetY);
  }

  release(): void {
    if (this.pressed) this.close();
  }

  /** Send the painted pixels; return false if there are none. */
  close(): boolean {
    const { path, outline } = this;
    const { width, height } = this.picture;
    const mask = new PaintedMask(width, height);
    if (path.length > 0) mask.brush(path, pictureBrush.peek() * width);
    else {
      const corners = outline.end();
      if (!corners) return false;
      mask.polygon(corners.map(([x, y]) => [((x + 1) / 2) * width, ((1 - y) / 2) * height]));
    }
    this.path = [];
    this.pressed = false;
    void this.send(mask);
    return true;
  }

  /** Discard the painted pixels; return false if there are none. */
  cancel(): boolean {
    const painting = this.path.length > 0 || this.pressed || this.outline.open;
    this.path = [];
    this.pressed = false;
    this.outline.cancel();
    this.wipe();
    return painting;
  }

  takeBack(): boolean {
    return this.outline.takeBack();
  }

  /** Extend the brush's path to a place on the canvas, CSS pixels, and draw it. */
  private extend(x: number, y: number): void {
    const { canvas, path, picture } = this;
    const scale = picture.width / canvas.clientWidth;
    path.push([x * scale, y * scale]);
    const pen = canvas.getContext('2d')!;
    const share = canvas.width / picture.width;
    this.wipe();
    Object.assign(pen, { lineWidth: 2 * pictureBrush.peek() * canvas.width, strokeStyle: brushColor(), globalAlpha: INK, lineCap: 'round', lineJoin: 'round' }); // prettier-ignore
    pen.beginPath();
    // A line without length draws its round ends.
    pen.moveTo(path[0]![0] * share, path[0]![1] * share);
    for (const [u, v] of path) pen.lineTo(u * share, v * share);
    pen.stroke();
  }

  private wipe(): void {
    this.canvas.getContext('2d')?.clearRect(0, 0, this.canvas.width, this.canvas.height);
  }

  /** Label the points behind the painted pixels, as one edit; the ink stays until the labels come. */
  private async send(mask: PaintedMask): Promise<void> {
    const { sequence, frame } = pictures.peek()!;
    const label = state.tool.peek() === 'paint' ? state.activeLabel.peek() : 0;
    const query = new URLSearchParams({ classes: `{"1": ${label}}`, source: 'painted' });
    const path = `${sequencePath(sequence)}/frames/${frame}/masks/${encodeURIComponent(this.picture.name)}`;
    await attempt('The picture was not painted', async () => {
      const { changed } = await api<MaskEdit>('PUT', `${path}?${query.toString()}`, mask.npy());
      if (changed === 0)
        notify('info', 'No point changed', 'The camera sees no other point there.');
    });
    if (this.path.length === 0) this.wipe();
  }
}

/** Return the reason why painting in a picture is refused now, or null. */
function refusalInPicture(): readonly [title: string, detail: string] | null {
  const tool = state.tool.peek();
  if (tool === 'delete' || tool === 'restore') return ['Not in a picture', OTHER_TOOL];
  if (!isStroke(tool)) actions.tools.setTool('paint');
  return refusal();
}
