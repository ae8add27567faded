/** A panel in the room: a plane with a canvas on it, pressed by a ray. */
import { CanvasTexture, LinearFilter, Matrix4, Mesh, MeshBasicMaterial, PlaneGeometry, SRGBColorSpace, Vector3 } from 'three'; // prettier-ignore
import { Ui, type Area } from './ui';

/** A texture takes its time to reach the GPU. */
const REDRAW_MS = 60;

export interface PanelSize {
  /** Metres. */
  readonly width: number;
  readonly height: number;
  readonly pixelsPerMetre: number;
  /** Metres of normal text's em. */
  readonly em: number;
}

export abstract class Panel {
  readonly mesh: Mesh<PlaneGeometry, MeshBasicMaterial>;
  protected readonly ui: Ui;
  private readonly texture: CanvasTexture;
  private dirty = true;
  private drawn = -Infinity;
  private pressed: Area | null = null;
  private readonly inverse = new Matrix4();
  private readonly from = new Vector3();
  private readonly way = new Vector3();
  /** Where the ray was last, pixels. */
  private readonly at = { x: 0, y: 0 };

  constructor(
    readonly size: PanelSize,
    order: number,
  ) {
    const { width, height, pixelsPerMetre, em } = size;
    const canvas = document.createElement('canvas');
    canvas.width = Math.round(width * pixelsPerMetre);
    canvas.height = Math.round(height * pixelsPerMetre);
    this.ui = new Ui(canvas.getContext('2d')!, canvas.width, canvas.height, em * pixelsPerMetre);
    this.texture = new CanvasTexture(canvas);
    this.texture.colorSpace = SRGBColorSpace;
    this.texture.minFilter = LinearFilter;
    this.texture.generateMipmaps = false;
    this.texture.anisotropy = 4;
    const material = new MeshBasicMaterial({
      map: this.texture, transparent: true, depthTest: false, depthWrite: false, toneMapped: false,
    }); // prettier-ignore
    this.mesh = new Mesh(new PlaneGeometry(width, height), material);
    this.mesh.renderOrder = order;
    this.mesh.frustumCulled = false;
  }

  protected abstract draw(ui: Ui): void;

  /** Draw anew at the next opportunity. */
  readonly touch = (): void => {
    this.dirty = true;
  };

  update(now: number): void {
    if (!this.dirty || !this.mesh.visible || now - this.drawn < REDRAW_MS) return;
    this.dirty = false;
    this.drawn = now;
    this.ui.begin();
    this.draw(this.ui);
    this.texture.needsUpdate = true;
  }

  /** Metres along the ray to the panel, or −1; remembers where. */
  meet(origin: Vector3, direction: Vector3): number {
    if (!this.mesh.visible || !this.mesh.parent?.visible) return -1;
    this.inverse.copy(this.mesh.matrixWorld).invert();
    this.from.copy(origin).applyMatrix4(this.inverse);
    this.way.copy(direction).transformDirection(this.inverse);
    // From behind a panel does not answer.
    if (this.from.z <= 0 || this.way.z > -0.05) return -1;
    const distance = -this.from.z / this.way.z;
    const u = (this.from.x + this.way.x * distance) / this.size.width + 0.5;
    const v = 0.5 - (this.from.y + this.way.y * distance) / this.size.height;
    if (this.pressed === null && (u < 0 || u > 1 || v < 0 || v > 1)) return -1;
    this.at.x = u * this.ui.width;
    this.at.y = v * this.ui.height;
    return distance;
  }

  /** The ray is on the panel (after `meet`). `edge` 1: pressed now, −1: let go. */
  point(edge: number): boolean {
    const { ui, at } = this;
    const hover = ui.find(at.x, at.y);
    const entered = hover !== ui.hover && hover >= 0;
    if (hover !== ui.hover) {
      ui.hover = hover;
      this.dirty = true;
    }
    if (edge === 1) {
      this.pressed = ui.areas[hover] ?? null;
      this.tell(this.pressed?.act);
    } else if (this.pressed?.drag) {
      this.tell(this.pressed.drag);
    }
    if (edge === -1) this.letGo();
    return entered || edge === 1;
  }

  get held(): boolean {
    return this.pressed !== null;
  }

  letGo(): void {
    this.pressed?.release?.();
    this.pressed = null;
  }

  leave(): void {
    if (this.pressed) this.letGo();
    if (this.ui.hover < 0) return;
    this.ui.hover = -1;
    this.dirty = true;
  }

  private tell(what: ((x: number, y: number) => void) | undefined): void {
    const area = this.pressed;
    if (!area || !what) return;
    const share = (value: number): number => Math.min(1, Math.max(0, value));
    what(share((this.at.x - area.x) / area.w), share((this.at.y - area.y) / area.h));
    this.dirty = true;
  }

  /** What answers to the ray, as shares of the panel: name, left, top, width, height. */
  places(): { name: string; x: number; y: number; w: number; h: number }[] {
    const { width, height, areas } = this.ui;
    return areas.map(({ name, x, y, w, h }) => ({
      name,
      x: x / width,
      y: y / height,
      w: w / width,
      h: h / height,
    }));
  }

  dispose(): void {
    this.mesh.removeFromParent();
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
    this.texture.dispose();
  }
}
