/** The number of the frame and its time: a small canvas of its own, since it changes all the time. */
import { CanvasTexture, LinearFilter, Mesh, MeshBasicMaterial, PlaneGeometry, SRGBColorSpace, type Object3D } from 'three'; // prettier-ignore
import { clock } from '../panels/format';
import { state } from '../state';
import { FONT, INK } from './ui';

/** Ems. */
const [WIDTH, HEIGHT] = [11.6, 2.3];
/** While it plays nobody reads each number. */
const PLAYING_MS = 120;

export class Readout {
  private readonly mesh: Mesh<PlaneGeometry, MeshBasicMaterial>;
  private readonly pen: CanvasRenderingContext2D;
  private readonly texture: CanvasTexture;
  private frame = -1;
  private sequence = '';
  private drawn = -Infinity;

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
    pen.font = `600 ${1.2 * em}px ${FONT}`;
    pen.fillStyle = INK.text;
    pen.fillText(`${frame} / ${info.frames - 1}`, 0, (HEIGHT * em) / 2);
    pen.font = `500 ${em}px ${FONT}`;
    pen.fillStyle = INK.quiet;
    pen.fillText(clock(frame / Math.max(info.fps, 1e-3)), 6.4 * em, (HEIGHT * em) / 2);
    this.texture.needsUpdate = true;
  }

  dispose(): void {
    this.mesh.removeFromParent();
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
    this.texture.dispose();
  }
}
