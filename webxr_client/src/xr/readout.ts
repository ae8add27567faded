/** The number of the frame and its time: a small canvas of its own, since it changes all the time. */
import { CanvasTexture, LinearFilter, Mesh, MeshBasicMaterial, PlaneGeometry, SRGBColorSpace, type Object3D } from 'three'; // prettier-ignore
import { state } from '../state';
import { FONT, INK } from './ui';

/** Ems. */
const [WIDTH, HEIGHT] = [11.6, 2.3];
/** While it plays nobody reads each number. */
const PLAYING_MS = 120;

const DIGITS = '0123456789';
const UNITS = [1, 10, 100, 1000, 10_000, 100_000, 1_000_000, 10_000_000];

interface Type {
  readonly font: string;
  /** Pixels from one digit to the next. */
  readonly pitch: number;
}

export class Readout {
  private readonly mesh: Mesh<PlaneGeometry, MeshBasicMaterial>;
  private readonly pen: CanvasRenderingContext2D;
  private readonly texture: CanvasTexture;
  private frame = -1;
  private sequence = '';
  private drawn = -Infinity;
  private readonly strong: Type;
  private readonly plain: Type;
  /** Where the next sign goes, and the width of a digit. */
  private x = 0;
  private pitch = 1;

  /** `em` in pixels. */
  constructor(
    private readonly em: number,
    pixelsPerMetre: number,
    order: number,
  ) {
    const canvas = document.createElement('canvas');
    canvas.width = Math.round(WIDTH * em);
    canvas.height = Math.round(HEIGHT * em);
    this.pen = canvas.getContext('2d')!;
    this.strong = this.type(`600 ${1.2 * em}px ${FONT}`);
    this.plain = this.type(`500 ${em}px ${FONT}`);
    this.texture = new CanvasTexture(canvas);
    this.texture.colorSpace = SRGBColorSpace;
    this.texture.minFilter = LinearFilter;
    this.texture.generateMipmaps = false;
    const look = { map: this.texture, transparent: true, depthTest: false, toneMapped: false };
    const size = [canvas.width / pixelsPerMetre, canvas.height / pixelsPerMetre] as const;
    this.mesh = new Mesh(new PlaneGeometry(...size), new MeshBasicMaterial(look));
    this.mesh.renderOrder = order;
    this.mesh.frustumCulled = false;
  }

  private type(font: string): Type {
    this.pen.font = font;
    return { font, pitch: this.pen.measureText('0').width };
  }

  /** Lie on a panel with the left edge at `x` and the middle at `y`, metres. */
  lieOn(panel: Object3D, x: number, y: number): void {
    panel.add(this.mesh);
    this.mesh.position.set(x + this.mesh.geometry.parameters.width / 2, y, 0.001);
  }

  update(now: number): void {
    const info = state.sequence.peek();
    const frame = state.frame.peek();
    this.mesh.visible = info !== null;
    if (!info || (frame === this.frame && info.id === this.sequence)) return;
    if (state.playing.peek() && now - this.drawn < PLAYING_MS) return;
    this.frame = frame;
    this.sequence = info.id;
    this.drawn = now;
    const { em, pen } = this;
    pen.fillStyle = INK.back;
    pen.fillRect(0, 0, WIDTH * em, HEIGHT * em);
    pen.textBaseline = 'middle';
    pen.textAlign = 'center';
    this.begin(this.strong, INK.text, 0);
    this.digits(frame);
    this.sign('/', 1.2);
    this.digits(info.frames - 1);
    this.begin(this.plain, INK.quiet, 6.4 * em);
    const hundredths = Math.round((100 * frame) / Math.max(info.fps, 1e-3));
    this.digits(Math.floor(hundredths / 6000));
    this.sign(':', 0.4);
    this.digits(Math.floor(hundredths / 100) % 60, 2);
    this.sign('.', 0.4);
    this.digits(hundredths % 100, 2);
    this.texture.needsUpdate = true;
  }

  private begin(type: Type, color: string, x: number): void {
    this.pen.font = type.font;
    this.pen.fillStyle = color;
    this.pitch = type.pitch;
    this.x = x;
  }

  /** Digit by digit, `least` of them or more: a text would be made anew for each frame. */
  private digits(value: number, least = 1): void {
    let places = least;
    while (places < UNITS.length && UNITS[places]! <= value) places++;
    while (places > 0) this.sign(DIGITS[Math.floor(value / UNITS[--places]!) % 10]!, 1);
  }

  /** `width` in digits. */
  private sign(text: string, width: number): void {
    const wide = width * this.pitch;
    this.pen.fillText(text, this.x + wide / 2, (HEIGHT * this.em) / 2);
    this.x += wide;
  }

  dispose(): void {
    this.mesh.removeFromParent();
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
    this.texture.dispose();
  }
}
