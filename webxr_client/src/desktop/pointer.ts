/** The mouse on the canvas: the tool with the left button, the camera with the others. */
import { Color, Matrix4, Vector3 } from 'three';
import { actions } from '../actions';
import { DELETED, type CloudFrame } from '../cloud/frame';
import { firstHit, inCapsule, type Hit } from '../cloud/pick';
import type { Viewer } from '../cloud/viewer';
import type { Brush, SequenceInfo } from '../protocol/messages';
import { activeLabel, canEdit, notify, state } from '../state';
import { LassoOutline } from '../tools/lasso';
import type { PointerSample } from '../tools/sample';
import type { Stroke, Strokes } from '../tools/strokes';
import { BrushRing } from './cursor';
import type { DeskCamera } from './camera';

export interface PointerDeps {
  readonly viewer: Viewer;
  readonly camera: DeskCamera;
  readonly strokes: Strokes;
  /** The frame on screen. */
  readonly frame: () => CloudFrame | null;
}

type Drag = 'turn' | 'pan' | 'stroke' | 'lasso';

/** Dabs lie this part of the brush's radius apart on screen. */
const DAB_SPACING = 0.4;
const MAX_DABS = 48;
const WIRE = { brush: 'ray', fill: 'grow', plane: 'plane', lasso: 'lasso' } as const;
const TOOL_COLORS = { erase: '#e8edf2', delete: '#ff5d5d', restore: '#7ddc8f' } as const;

export class DeskPointer {
  /** Where the brush is on the surface, room coordinates; null off the recording. */
  brushAt: Vector3 | null = null;
  private drag: Drag | null = null;
  private stroke: Stroke | null = null;
  private readonly last = { x: 0, y: 0 };
  private readonly cursor = { x: 0, y: 0, inside: false, moved: false };
  private readonly ring = new BrushRing();
  private readonly lasso: LassoOutline;
  private readonly canvas: HTMLCanvasElement;
  private readonly toLocal = new Matrix4();
  private readonly color = new Color();
  private readonly scratch = new Vector3();
  private readonly abort = new AbortController();

  constructor(private readonly deps: PointerDeps) {
    this.canvas = deps.viewer.canvas;
    this.lasso = new LassoOutline(this.canvas);
    deps.viewer.scene.add(this.ring.object);
    const { signal } = this.abort;
    const on = <K extends keyof HTMLElementEventMap>(
      type: K,
      listen: (event: HTMLElementEventMap[K]) => void,
    ): void => this.canvas.addEventListener(type, listen, { signal, passive: false });
    on('pointerdown', (event) => this.down(event));
    on('pointermove', (event) => this.move(event));
    on('pointerup', (event) => this.up(event));
    on('pointercancel', (event) => this.up(event));
    on('pointerleave', () => this.leave());
    on('wheel', (event) => this.wheel(event));
    on('contextmenu', (event) => event.preventDefault());
  }

  dispose(): void {
    this.abort.abort();
    this.ring.object.removeFromParent();
  }

  // ── events ─────────────────────────────────────────────────────────────────────────────────

  private down(event: PointerEvent): void {
    if (this.drag) return;
    this.canvas.focus({ preventScroll: true });
    event.preventDefault();
    this.place(event);
    this.drag = this.chooseDrag(event);
    if (this.drag) this.canvas.setPointerCapture(event.pointerId);
    this.last.x = event.offsetX;
    this.last.y = event.offsetY;
  }

  private chooseDrag(event: PointerEvent): Drag | null {
    if (event.button === 2) return this.pivotUnderCursor('pan');
    if (event.button === 1 || event.altKey) return this.pivotUnderCursor('turn');
    if (event.button !== 0) return null;
    const tool = state.tool.peek();
    if (tool === 'navigate') return this.pivotUnderCursor('turn');
    if (tool === 'pick') {
      this.pickLabel();
      return null;
    }
    return this.beginStroke();
  }

  private pivotUnderCursor(drag: Drag): Drag {
    const hit = this.hit(0.05);
    if (hit) this.deps.camera.pivot.copy(this.roomPosition(hit));
    return drag;
  }

  private move(event: PointerEvent): void {
    const { x, y } = this.last;
    this.place(event);
    if (this.drag === 'turn') this.deps.camera.turn(event.offsetX - x, event.offsetY - y);
    if (this.drag === 'pan') {
      this.deps.camera.pan(event.offsetX - x, event.offsetY - y, this.canvas.clientHeight);
    }
    if (this.drag === 'stroke') {
      for (const part of event.getCoalescedEvents()) this.dabsTo(part.offsetX, part.offsetY);
      this.dabsTo(event.offsetX, event.offsetY);
    }
    if (this.drag === 'lasso') this.lasso.add(event.offsetX, event.offsetY);
    this.last.x = event.offsetX;
    this.last.y = event.offsetY;
    this.deps.viewer.invalidate();
  }

  private up(event: PointerEvent): void {
    if (this.drag === 'stroke') {
      this.stroke?.end();
      this.stroke = null;
    }
    if (this.drag === 'lasso') this.endLasso();
    this.drag = null;
    if (this.canvas.hasPointerCapture(event.pointerId)) {
      this.canvas.releasePointerCapture(event.pointerId);
    }
  }

  private leave(): void {
    this.cursor.inside = false;
    this.cursor.moved = true;
    this.deps.viewer.invalidate();
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    this.place(event);
    const notches = -event.deltaY / (event.deltaMode === 0 ? 100 : 3);
    if (event.ctrlKey && !event.metaKey && Math.abs(event.deltaY) >= 50) {
      actions.nudgeRadius(Math.sign(notches));
      return;
    }
    const hit = this.hit(0.1);
    const target = hit ? this.roomPosition(hit) : this.ahead();
    this.deps.camera.zoom(event.ctrlKey ? notches * 4 : notches, target);
    this.deps.viewer.invalidate();
  }

  private place(event: MouseEvent): void {
    this.cursor.x = event.offsetX;
    this.cursor.y = event.offsetY;
    this.cursor.inside = true;
    this.cursor.moved = true;
  }

  // ── strokes ────────────────────────────────────────────────────────────────────────────────

  /** The brush of the settings, or null with a word to the user. */
  private brush(): Brush | null {
    const tool = state.tool.peek();
    if (tool === 'navigate' || tool === 'pick') return null;
    const { shape, radius, onlyUnlabeled, through } = state.brush.peek();
    const label = tool === 'paint' ? state.activeLabel.peek() : 0;
    if (tool === 'paint' && label === 0) {
      notify('info', 'Choose a label first', 'Make one with the + beside “Labels”, or press N.');
      return null;
    }
    if (tool === 'paint' && activeLabel.peek()?.locked) {
      notify('info', 'This label is locked', 'Unlock it, or choose another one.');
      return null;
    }
    const wire = WIRE[shape];
    return { label, tool, shape: wire, radius, only_unlabeled: onlyUnlabeled, through };
  }

  private beginStroke(): Drag | null {
    const frame = this.deps.frame();
    const info = state.sequence.peek();
    if (!frame || !info) return null;
    if (state.brush.peek().shape !== 'lasso' && !this.hit(state.brush.peek().radius)) return 'turn';
    if (!canEdit.peek()) {
      notify('info', 'You are a viewer here', 'Ask for an annotator’s token to paint.');
      return null;
    }
    const brush = this.brush();
    if (!brush) return null;
    // Painting on a moving picture would paint what one no longer sees.
    if (state.playing.peek()) actions.pause();
    if (brush.shape === 'lasso') {
      this.lasso.begin(this.cursor.x, this.cursor.y, this.toolColor());
      return 'lasso';
    }
    this.stroke = this.deps.strokes.begin(frame, brush, info.shift);
    this.stroke.add(this.ray(this.cursor.x, this.cursor.y));
    return 'stroke';
  }

  /** Dabs between the last place and this one, close enough to make a line. */
  private dabsTo(x: number, y: number): void {
    const { shape } = state.brush.peek();
    if (!this.stroke || shape === 'fill' || shape === 'plane') return;
    const distance = Math.hypot(x - this.last.x, y - this.last.y);
    if (distance < 0.5) return;
    const gap = Math.max(2, this.radiusPixels() * DAB_SPACING);
    const dabs = Math.min(MAX_DABS, Math.ceil(distance / gap));
    for (let i = 1; i <= dabs; i++) {
      const t = i / dabs;
      this.stroke.add(
        this.ray(this.last.x + (x - this.last.x) * t, this.last.y + (y - this.last.y) * t),
      );
    }
    this.last.x = x;
    this.last.y = y;
  }

  /** The brush's radius on screen where it last met the surface. */
  private radiusPixels(): number {
    const { camera } = this.deps.viewer;
    const distance = state.hover.peek()?.distance ?? 2;
    const half = Math.tan((camera.fov * Math.PI) / 360) * distance;
    return (state.brush.peek().radius / half) * (this.canvas.clientHeight / 2);
  }

  private endLasso(): void {
    const polygon = this.lasso.end();
    const frame = this.deps.frame();
    const info = state.sequence.peek();
    const brush = this.brush();
    if (!polygon || !frame || !info || !brush) return;
    const stroke = { ...brush, polygon, matrix: this.clipFromSource(info) };
    this.deps.strokes.begin(frame, stroke, info.shift).end();
  }

  /** Row-major `clip_from_source` of what is on screen. */
  private clipFromSource(info: SequenceInfo): number[] {
    const { camera, room } = this.deps.viewer;
    const [x, y, z] = info.shift;
    return new Matrix4()
      .multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse)
      .multiply(room.matrixWorld)
      .multiply(new Matrix4().makeTranslation(-x, -y, -z))
      .transpose()
      .toArray();
  }

  private pickLabel(): void {
    const hit = this.hit(0.03);
    const label = hit ? (this.deps.frame()?.labelOf(hit.point) ?? 0) : 0;
    if (label === 0 || label === DELETED) return;
    actions.selectLabel(label);
    actions.setTool('paint');
  }

  // ── rays ───────────────────────────────────────────────────────────────────────────────────

  /** The ray through a place on the canvas, in local coordinates. */
  private ray(x: number, y: number): PointerSample {
    const { camera, room } = this.deps.viewer;
    camera.updateMatrixWorld();
    const far = this.scratch
      .set((x / this.canvas.clientWidth) * 2 - 1, 1 - (y / this.canvas.clientHeight) * 2, 0.5)
      .unproject(camera);
    this.toLocal.copy(room.matrixWorld).invert();
    const eye = new Vector3().copy(camera.position).applyMatrix4(this.toLocal);
    const direction = far.applyMatrix4(this.toLocal).sub(eye).normalize();
    return {
      origin: [eye.x, eye.y, eye.z],
      direction: [direction.x, direction.y, direction.z],
    };
  }

  private hit(radius: number): Hit | null {
    const frame = this.deps.frame();
    if (!frame || !this.cursor.inside) return null;
    const { origin, direction } = this.ray(this.cursor.x, this.cursor.y);
    return firstHit(frame, origin, direction, radius);
  }

  private roomPosition(hit: Hit): Vector3 {
    return new Vector3(...hit.position).applyMatrix4(this.deps.viewer.room.matrixWorld);
  }

  /** Where the wheel goes when nothing is under the cursor. */
  private ahead(): Vector3 {
    const { camera } = this.deps.viewer;
    const { origin, direction } = this.ray(this.cursor.x, this.cursor.y);
    const distance = Math.max(1, camera.position.distanceTo(this.deps.camera.pivot));
    return new Vector3(...direction)
      .multiplyScalar(distance)
      .add(new Vector3(...origin))
      .applyMatrix4(this.deps.viewer.room.matrixWorld);
  }

  // ── what the brush shows ───────────────────────────────────────────────────────────────────

  private toolColor(): string {
    const tool = state.tool.peek();
    if (tool === 'paint') return activeLabel.peek()?.color ?? '#ffffff';
    return tool === 'erase' || tool === 'delete' || tool === 'restore'
      ? TOOL_COLORS[tool]
      : '#ffffff';
  }

  /** Settings changed: the brush must be drawn anew although the mouse is still. */
  refresh(): void {
    this.cursor.moved = true;
    this.deps.viewer.invalidate();
  }

  /** Before each picture: light up the points under the brush. */
  update(): void {
    if (!this.cursor.moved || this.drag === 'turn' || this.drag === 'pan') return;
    this.cursor.moved = false;
    const { uniforms, camera } = this.deps.viewer;
    const tool = state.tool.peek();
    const { shape, radius, onlyUnlabeled, through } = state.brush.peek();
    const painting = tool !== 'navigate' && tool !== 'pick';
    const hit = this.cursor.inside ? this.hit(painting ? radius : 0.03) : null;
    const frame = this.deps.frame();
    if (!hit || !frame) {
      this.hideBrush();
      return;
    }
    this.color.set(this.toolColor());
    const brushed = painting && shape !== 'lasso';
    if (brushed) {
      const half = Math.tan((camera.fov * Math.PI) / 360) * hit.distance;
      const pixel = half / (this.canvas.clientHeight / 2);
      this.brushAt = this.roomPosition(hit);
      this.ring.show(this.brushAt, radius, this.color, camera, pixel);
      const { r, g, b } = srgb(this.color);
      uniforms.brushColour.value.set(r, g, b);
      uniforms.brushRadius.value = radius;
      uniforms.brushOnlyUnlabeled.value = tool === 'paint' && onlyUnlabeled ? 1 : 0;
      this.aim(hit, through && shape === 'brush');
    } else {
      this.ring.hide();
      this.brushAt = null;
      uniforms.brushMode.value = 0;
    }
    let points = 0;
    if (brushed) inCapsule(frame, hit.position, hit.position, radius, () => (points += 1));
    state.hover.value = { label: frame.labelOf(hit.point), distance: hit.distance, points };
  }

  private aim(hit: Hit, through: boolean): void {
    const { uniforms } = this.deps.viewer;
    if (through) {
      const { origin, direction } = this.ray(this.cursor.x, this.cursor.y);
      uniforms.brushMode.value = 2;
      uniforms.brushA.value.set(...origin);
      uniforms.brushB.value.set(...direction);
      return;
    }
    uniforms.brushMode.value = 1;
    uniforms.brushA.value.set(...hit.position);
    uniforms.brushB.value.set(...hit.position);
  }

  private hideBrush(): void {
    this.ring.hide();
    this.brushAt = null;
    this.deps.viewer.uniforms.brushMode.value = 0;
    if (state.hover.peek()) state.hover.value = null;
  }
}

/** A colour's values as the points' shader mixes them: with gamma. */
function srgb(color: Color): { r: number; g: number; b: number } {
  return color.clone().convertLinearToSRGB();
}
