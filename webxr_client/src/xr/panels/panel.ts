/** A panel in the room: a plane with a canvas on it, pressed by a ray. */
import { CanvasTexture, LinearFilter, Matrix4, Mesh, MeshBasicMaterial, PlaneGeometry, SRGBColorSpace, Vector2, Vector3 } from 'three'; // prettier-ignore
import { Fold } from './fold';
import { tint } from '../drawing/tint';
import { GLASS, LIGHT, Ui, type Area, type ButtonLook } from '../drawing/ui';

/** Metres behind the panel to which a fingertip still presses it. */
const THROUGH = 0.04;
/** A texture takes its time to reach the GPU. */
const REDRAW_MS = 60;
/** Ems: height of a handle. */
export const HANDLE_EMS = 2.1;

export interface PanelSize {
  /** Metres. */
  readonly width: number;
  readonly height: number;
  readonly pixelsPerMetre: number;
  /** Metres of normal text's em. */
  readonly em: number;
  /** All that is left of it while it is folded: its middle, a share of the lower edge, and ems. */
  readonly handle?: { readonly at: number; readonly wide: number };
}

export abstract class Panel {
  readonly mesh: Mesh<PlaneGeometry, MeshBasicMaterial>;
  protected readonly ui: Ui;
  private readonly texture: CanvasTexture;
  private dirty = true;
  private drawn = -Infinity;
  private pressed: Area | null = null;
  /** The pointer that presses it: no other moves it meanwhile. */
  private holder: object | null = null;
  /** The area that the ray is on, and the light on it. */
  private hover = -1;
  private readonly light: Mesh<PlaneGeometry, MeshBasicMaterial>;
  private readonly inverse = new Matrix4();
  private readonly from = new Vector3();
  private readonly way = new Vector3();
  /** Place where the ray met it last, pixels, and metres along the ray. */
  private readonly at = new Float64Array(2);
  /** The same in metres to the right of the panel's middle and above it. */
  readonly heldAt = new Vector2();
  /** Drawn faintly over the scene, so that a panel behind nearer points is still visible. */
  private readonly veil: Mesh<PlaneGeometry, MeshBasicMaterial>;
  readonly distance = new Float64Array(1);
  private readonly fold = new Fold();

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
    const face = { map: this.texture, transparent: true, toneMapped: false };
    // Round corners hide nothing.
    const material = new MeshBasicMaterial({ ...face, alphaTest: 0.5 });
    this.mesh = new Mesh(new PlaneGeometry(width, height), material);
    this.mesh.renderOrder = order;
    this.mesh.frustumCulled = false;
    const faint = { opacity: GLASS.veil, depthTest: false, depthWrite: false };
    this.veil = new Mesh(this.mesh.geometry, new MeshBasicMaterial({ ...face, ...faint }));
    this.veil.renderOrder = order - 0.5;
    this.veil.frustumCulled = false;
    const glass = { vertexColors: true, transparent: true, depthWrite: false, toneMapped: false };
    const quad = new PlaneGeometry(1, 1);
    tint(quad, LIGHT.color, LIGHT.opacity);
    this.light = new Mesh(quad, new MeshBasicMaterial(glass));
    this.light.renderOrder = order + 0.5;
    this.light.position.z = 0.0002;
    this.light.frustumCulled = this.light.visible = false;
    this.mesh.add(this.light, this.veil);
  }

  /** Make the panel translucent during a stroke. */
  fade(on: boolean): void {
    this.mesh.material.visible = !on;
  }

  protected abstract draw(ui: Ui): void;

  /** Words and marks on the handle. */
  protected handleLook(): ButtonLook {
    return {};
  }

  // ── folding ────────────────────────────────────────────────────────────────────────────────

  get folded(): boolean {
    return this.size.handle !== undefined && this.fold.folded;
  }

  /** Whether it is unfolded, and its buttons can be pressed. */
  get open(): boolean {
    return !this.folded && !this.fold.isJustUnfolded;
  }

  /** Fold to the handle, or unfold; drawn buttons are disabled. */
  setFolded(folded: boolean): void {
    if (folded === this.folded) return;
    this.fold.set(folded);
    this.ui.areas.length = 0;
    this.hover = -1;
    this.light.visible = false;
    this.drawn = -Infinity;
    this.touch();
  }

  /** Once per picture: see `Fold.update`. */
  updateFold(...args: Parameters<Fold['update']>): void {
    if (this.size.handle && this.fold.update(...args)) this.setFolded(!this.folded);
  }

  /** The middle of its visible part, or a place −1..1 from there, in the headset's own space. */
  middle(out: Vector3, right = 0, up = 0): Vector3 {
    const { width, height, em, handle } = this.size;
    if (handle && this.folded) {
      const x = (handle.at - 0.5) * width + (right * handle.wide * em) / 2;
      out.set(x, ((1 + up) * HANDLE_EMS * em - height) / 2, 0);
    } else out.set((right * width) / 2, (up * height) / 2, 0);
    return out.applyMatrix4(this.mesh.matrix);
  }

  private drawHandle({ at, wide }: { at: number; wide: number }): void {
    const { ui } = this;
    const [w, h] = [wide * ui.em, HANDLE_EMS * ui.em];
    const [x, y] = [at * ui.width - w / 2, ui.height - h];
    ui.begin(x, y, w, h);
    ui.button(x, y, w, h, this.handleLook(), () => this.setFolded(false));
  }

  /** Draw anew at the next opportunity. */
  readonly touch = (): void => {
    this.dirty = true;
  };

  update(now: number): void {
    if (!this.dirty || !this.mesh.visible || now - this.drawn < REDRAW_MS) return;
    this.dirty = false;
    this.drawn = now;
    if (this.folded) this.drawHandle(this.size.handle!);
    else {
      this.ui.begin();
      this.draw(this.ui);
    }
    this.lighten();
    this.texture.needsUpdate = true;
  }

  /** Whether the ray is on the panel; remembers where, and how far that is. */
  meet(origin: Vector3, direction: Vector3): boolean {
    if (!this.mesh.visible || !this.mesh.parent?.visible) return false;
    if (this.carried) return true;
    this.inverse.copy(this.mesh.matrixWorld).invert();
    this.from.copy(origin).applyMatrix4(this.inverse);
    this.way.copy(direction).transformDirection(this.inverse);
    // From behind a panel does not answer.
    if (this.from.z <= 0 || this.way.z > -0.05) return false;
    const distance = -this.from.z / this.way.z;
    const u = (this.from.x + this.way.x * distance) / this.size.width + 0.5;
    const v = 0.5 - (this.from.y + this.way.y * distance) / this.size.height;
    if (!this.takes(u, v)) return false;
    this.heldAt.set((u - 0.5) * this.size.width, (0.5 - v) * this.size.height);
    this.distance[0] = distance * this.grown();
    return true;
  }

  /** Whether a fingertip is over the panel, nearer than `reach`; remembers where, and how far. */
  touched(tip: Vector3, reach: number): boolean {
    if (!this.mesh.visible || !this.mesh.parent?.visible) return false;
    const { from, inverse } = this;
    from.copy(tip).applyMatrix4(inverse.copy(this.mesh.matrixWorld).invert());
    const distance = from.z * this.grown();
    if (distance > reach || distance < -THROUGH) return false;
    const u = from.x / this.size.width + 0.5;
    const v = 0.5 - from.y / this.size.height;
    if (!this.takes(u, v)) return false;
    this.distance[0] = distance;
    return true;
  }

  /** Whether it answers at a place, 0..1, and notes that: anywhere while it is pressed. */
  private takes(u: number, v: number): boolean {
    const { at, ui } = this;
    if (this.pressed === null && (u < 0 || u > 1 || v < 0 || v > 1)) return false;
    at[0] = u * ui.width;
    at[1] = v * ui.height;
    return this.pressed !== null || !this.folded || ui.find(at) >= 0;
  }

  /** Metres of the scene in one of its own. */
  private grown(): number {
    const e = this.mesh.matrixWorld.elements;
    return Math.sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
  }

  /** `by` is on the panel (after `meet` or `touched`). `edge` 1: pressed now, −1: let go. */
  point(edge: number, by: object): boolean {
    const { ui, at } = this;
    const hover = ui.find(at);
    const entered = hover !== this.hover && hover >= 0;
    if (hover !== this.hover) {
      this.hover = hover;
      this.lighten();
    }
    if (edge === 1) {
      this.pressed = (this.fold.isJustUnfolded ? null : ui.areas[hover]) ?? null;
      this.holder = by;
      this.callAtPointer(this.pressed?.act);
    } else if (this.pressed?.drag) {
      this.callAtPointer(this.pressed.drag);
    }
    if (edge === -1) this.letGo();
    return entered || edge === 1;
  }

  heldBy(one: object): boolean {
    return this.pressed !== null && this.holder === one;
  }

  /** Nothing presses it. */
  get isFree(): boolean {
    return this.pressed === null;
  }

  /** It hangs from the ray that holds its bar. */
  get carried(): boolean {
    return this.pressed?.moves === true;
  }

  private letGo(): void {
    this.pressed?.release?.();
    this.pressed = this.holder = null;
  }

  /** `one` is not on it any more. */
  leave(one: object): void {
    if (this.heldBy(one)) this.letGo();
    if (!this.isFree) return;
    this.hover = -1;
    this.light.visible = false;
  }

  /** Highlight the ray's target without drawing the panel again. */
  private lighten(): void {
    const { light, size, ui } = this;
    const area = ui.areas[this.hover];
    light.visible = area !== undefined && !area.plain;
    if (!area) return;
    const { width, height, pixelsPerMetre } = size;
    light.scale.set(area.w / pixelsPerMetre, area.h / pixelsPerMetre, 1);
    light.position.x = (area.x + area.w / 2) / pixelsPerMetre - width / 2;
    light.position.y = height / 2 - (area.y + area.h / 2) / pixelsPerMetre;
  }

  private callAtPointer(what: ((x: number, y: number) => void) | undefined): void {
    const area = this.pressed;
    if (!area || !what) return;
    const share = (value: number): number => Math.min(1, Math.max(0, value));
    what(share((this.at[0]! - area.x) / area.w), share((this.at[1]! - area.y) / area.h));
    this.dirty = true;
  }

  /** Name of the control under the ray; null: none. */
  get pointedAt(): string | null {
    return this.ui.areas[this.hover]?.name ?? null;
  }

  /** Areas that answer to the ray, as shares of the panel: name, left, top, width, height. */
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
    for (const { geometry, material } of [this.mesh, this.light, this.veil]) {
      geometry.dispose();
      material.dispose();
    }
    this.texture.dispose();
  }
}
