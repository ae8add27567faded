/** A line of text in the room. */
import { free } from '../../common/free';
import { CanvasTexture, Mesh, MeshBasicMaterial, PlaneGeometry, SRGBColorSpace } from 'three';
import { FONT, INK } from './ui';

export interface SignLook {
  /** Metres of the text's em. */
  readonly em: number;
  readonly color?: string;
  readonly back?: string;
  readonly order?: number;
  /** Nearer things hide it. */
  readonly depth?: boolean;
}

const PIXELS = 48;

export class Sign {
  readonly mesh: Mesh<PlaneGeometry, MeshBasicMaterial>;
  private readonly canvas = document.createElement('canvas');
  private texture: CanvasTexture | null = null;
  private text = '';

  constructor(private readonly look: SignLook) {
    const material = new MeshBasicMaterial({
      transparent: true,
      depthTest: look.depth ?? false,
      depthWrite: false,
      toneMapped: false,
    });
    this.mesh = new Mesh(new PlaneGeometry(1, 1), material);
    this.mesh.renderOrder = look.order ?? 115;
    this.mesh.frustumCulled = false;
    this.mesh.visible = false;
  }

  /** Write one or more lines; an empty text hides the sign. */
  write(text: string): void {
    this.mesh.visible = text !== '';
    if (text === this.text || text === '') return;
    this.text = text;
    this.draw(text);
  }

  private draw(text: string): void {
    const lines = text.split('\n');
    const pen = this.canvas.getContext('2d')!;
    const font = `600 ${PIXELS}px ${FONT}`;
    pen.font = font;
    const pad = PIXELS * 0.6;
    const width = Math.ceil(
      Math.max(...lines.map((line) => pen.measureText(line).width)) + 2 * pad,
    );
    const height = Math.ceil(PIXELS * (1.3 * lines.length + 0.5));
    this.canvas.width = width;
    this.canvas.height = height;
    pen.fillStyle = this.look.back ?? '#05070a';
    pen.beginPath();
    pen.roundRect(0, 0, width, height, PIXELS * 0.4);
    pen.fill();
    pen.font = font;
    pen.fillStyle = this.look.color ?? INK.text;
    pen.textBaseline = 'middle';
    lines.forEach((line, i) => pen.fillText(line, pad, PIXELS * (0.92 + 1.3 * i)));
    // A texture keeps its size for good: another text needs another one.
    this.texture?.dispose();
    this.texture = new CanvasTexture(this.canvas);
    this.texture.colorSpace = SRGBColorSpace;
    this.mesh.material.map = this.texture;
    this.mesh.material.needsUpdate = true;
    this.mesh.scale.set((width / PIXELS) * this.look.em, (height / PIXELS) * this.look.em, 1);
  }

  dispose(): void {
    free(this.mesh);
    this.texture?.dispose();
  }
}
