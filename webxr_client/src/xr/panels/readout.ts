/**
 * The number of the frame and its time.  They change all the time: each sign is a quad that shows its
 * place of a canvas drawn once, so that another number moves some corners and draws nothing.
 */
import { free } from '../../common/free';
import { BufferGeometry, CanvasTexture, DynamicDrawUsage, Float32BufferAttribute, Mesh, MeshBasicMaterial, SRGBColorSpace, type Object3D } from 'three'; // prettier-ignore
import { state } from '../../store/state';
import type { SequenceInfo } from '../../protocol/messages';
import { FONT, INK } from '../drawing/ui';

const SIGNS = '0123456789/:.';
const [SLASH, COLON, POINT] = [10, 11, 12];
const UNITS = [1, 10, 100, 1000, 10_000, 100_000, 1_000_000, 10_000_000];
/** Most signs at a time. */
const MOST = 32;
/** A quad's corners as two triangles. */
const CORNERS = [0, 1, 2, 2, 1, 3] as const;
/** Ems: of the frame's number, of the time, where the time begins, and the height of a row. */
const [STRONG, PLAIN, TIME_AT, ROW] = [1.2, 1, 6.4, 1.6];

/** One row of the canvas: a size and a colour. */
interface Type {
  /** The row from the top, and the width of its cells, which is a digit's, pixels. */
  readonly row: number;
  readonly pitch: number;
}

export class Readout {
  private readonly mesh: Mesh<BufferGeometry, MeshBasicMaterial>;
  private readonly places = attribute(3);
  private readonly parts = attribute(2);
  private readonly pen = document.createElement('canvas').getContext('2d')!;
  private frame = -1;
  private sequence = '';
  private readonly strong: Type;
  private readonly plain: Type;
  private count = 0;
  /** Signs of the frame's number, which come first. */
  private numbers = 0;
  /** Place of the next sign, pixels. */
  private readonly x = new Float64Array(1);

  /** `em` in pixels. */
  constructor(
    private readonly em: number,
    private readonly pixelsPerMetre: number,
    order: number,
  ) {
    const { canvas } = this.pen;
    canvas.width = Math.ceil(SIGNS.length * em);
    canvas.height = Math.ceil(2 * ROW * em);
    this.strong = this.write(0, `600 ${STRONG * em}px ${FONT}`, INK.text);
    this.plain = this.write(1, `500 ${PLAIN * em}px ${FONT}`, INK.quiet);
    const map = new CanvasTexture(canvas);
    map.colorSpace = SRGBColorSpace;
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', this.places);
    geometry.setAttribute('uv', this.parts);
    const look = { map, transparent: true, depthWrite: false, toneMapped: false };
    this.mesh = new Mesh(geometry, new MeshBasicMaterial(look));
    this.mesh.renderOrder = order;
    this.mesh.frustumCulled = false;
  }

  /** Write every sign into a row, each in the middle of its cell. */
  private write(row: number, font: string, color: string): Type {
    const { pen, em } = this;
    pen.font = font;
    pen.fillStyle = color;
    pen.textBaseline = 'middle';
    pen.textAlign = 'center';
    const pitch = pen.measureText('0').width;
    for (let i = 0; i < SIGNS.length; i++) {
      pen.fillText(SIGNS[i]!, (i + 0.5) * pitch, (row + 0.5) * ROW * em);
    }
    return { row, pitch };
  }

  /** Lie on a panel. */
  lieOn(panel: Object3D): void {
    panel.add(this.mesh);
  }

  /** Begin at a place of the panel, metres; `brief`: the frame's number alone. */
  update([x, y]: readonly [number, number], brief: boolean): void {
    const info = state.sequence.peek();
    const frame = state.frame.peek();
    this.mesh.visible = info !== null;
    this.mesh.position.set(x, y, 0.001);
    if (info) this.updateText(info, frame);
    this.mesh.geometry.setDrawRange(0, CORNERS.length * (brief ? this.numbers : this.count));
  }

  private updateText(info: SequenceInfo, frame: number): void {
    if (frame === this.frame && info.id === this.sequence) return;
    this.frame = frame;
    this.sequence = info.id;
    this.count = 0;
    this.x[0] = 0;
    this.digits(this.strong, frame, 1);
    this.sign(this.strong, SLASH);
    this.digits(this.strong, info.frames - 1, 1);
    this.numbers = this.count;
    this.x[0] = TIME_AT * this.em;
    const hundredths = Math.round((100 * frame) / Math.max(info.fps, 1e-3));
    this.digits(this.plain, Math.floor(hundredths / 6000), 1);
    this.sign(this.plain, COLON);
    this.digits(this.plain, Math.floor(hundredths / 100) % 60, 2);
    this.sign(this.plain, POINT);
    this.digits(this.plain, hundredths % 100, 2);
    this.places.needsUpdate = this.parts.needsUpdate = true;
  }

  /** Digit by digit, `least` of them or more. */
  private digits(type: Type, value: number, least: number): void {
    let places = least;
    while (places < UNITS.length && UNITS[places]! <= value) places++;
    while (places > 0) this.sign(type, Math.floor(value / UNITS[--places]!) % 10);
  }

  /** One cell of the canvas, side by side with the last; signs that are no digits are narrower. */
  private sign({ row, pitch }: Type, sign: number): void {
    const { em, pixelsPerMetre, x, count } = this;
    if (count >= MOST) return;
    const { width, height } = this.pen.canvas;
    const places = this.places.array;
    const parts = this.parts.array;
    const wide = sign > SLASH ? 0.45 * pitch : pitch;
    const middle = x[0]! + wide / 2;
    for (let k = 0; k < CORNERS.length; k++) {
      const corner = CORNERS[k]!;
      const vertex = CORNERS.length * count + k;
      const right = corner & 1;
      const up = corner >> 1;
      places[3 * vertex] = (middle + (right - 0.5) * wide) / pixelsPerMetre;
      places[3 * vertex + 1] = ((up - 0.5) * ROW * em) / pixelsPerMetre;
      parts[2 * vertex] = ((sign + 0.5) * pitch + (right - 0.5) * wide) / width;
      parts[2 * vertex + 1] = 1 - ((row + 1 - up) * ROW * em) / height;
    }
    x[0] = x[0]! + wide;
    this.count += 1;
  }

  dispose(): void {
    this.mesh.material.map!.dispose();
    free(this.mesh);
  }
}

function attribute(size: number): Float32BufferAttribute {
  const numbers = new Float32Array(size * CORNERS.length * MOST);
  return new Float32BufferAttribute(numbers, size).setUsage(DynamicDrawUsage);
}
