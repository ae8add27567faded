/** The mouse on the canvas: the tool with the left button, the camera with the others. */
import type { Vector3 } from 'three';
import type { ObjectBoxes } from '../boxes/index';
import { actions } from '../store/actions';
import { type CloudFrame } from '../cloud/points/frame';
import type { Viewer } from '../cloud/picture/viewer';
import { isStroke, state } from '../store/state';
import type { PointerSample } from '../store/types';
import type { AheadPreview } from '../tools/preview';
import { boxDraft } from '../tools/volume';
import { brushColor, brushFor } from '../tools/brush';
import { outlineKind, type LassoOutline } from '../tools/lasso';
import type { ObjectTool } from '../tools/object';
import { Path } from '../tools/path';
import type { RegionPreview } from '../tools/region';
import type { Stroke, Strokes } from '../tools/strokes';
import { completes, deskWay } from '../tools/ways';
import { scrollClip } from '../tools/clip';
import { Aim } from '../view/aim';
import { BoxPress } from './box-press';
import { BoxTool } from './box-tool';
import { cursorOf } from './cursors';
import type { DeskCamera } from '../view/camera';
import { BrushLight } from './light';
import { Touches, type Pinch } from './touches';
import { LassoTool } from './lasso-tool';
import { VolumeHandles } from './volumes';

export interface PointerDeps {
  readonly viewer: Viewer;
  readonly camera: DeskCamera;
  readonly strokes: Strokes;
  readonly objects: ObjectTool;
  readonly regions: RegionPreview;
  readonly ahead: AheadPreview;
  /** The frame on screen. */
  readonly frame: () => CloudFrame | null;
  readonly boxes: ObjectBoxes;
}

type Drag = 'turn' | 'pan' | 'stroke' | 'lasso' | 'box' | 'handle' | 'pinch' | 'tap';

/** Dabs lie this part of the brush's radius apart on screen. */
const DAB_SPACING = 0.4;
const MAX_DABS = 48;
/** Notches of the wheel that bring the camera as close as fingers e times farther apart. */
const NOTCHES_PER_E = 1 / -Math.log(0.86);

export class DeskPointer {
  private drag: Drag | null = null;
  private stroke: Stroke | null = null;
  private readonly last = { x: 0, y: 0 };
  /** Notches of the wheel that are no level yet. */
  private turned = 0;
  /** Path of the stroke, to be completed to an object. */
  private readonly path = new Path();
  private readonly aim: Aim;
  private readonly light: BrushLight;
  private readonly outlines: LassoTool;
  private readonly lasso: LassoOutline;
  private readonly boxes: BoxTool;
  private readonly handles: VolumeHandles;
  private readonly boxPress: BoxPress;
  private readonly canvas: HTMLCanvasElement;
  private readonly touches = new Touches();

  constructor(private readonly deps: PointerDeps) {
    this.canvas = deps.viewer.canvas;
    this.aim = new Aim(deps.viewer, deps.frame);
    this.light = new BrushLight(deps.viewer, this.aim);
    this.boxes = new BoxTool({ ...deps, aim: this.aim });
    this.outlines = new LassoTool(this.canvas, { ...deps, aim: this.aim });
    this.lasso = this.outlines.outline;
    this.handles = new VolumeHandles(deps.viewer, this.aim);
    this.boxPress = new BoxPress(this.aim, deps.boxes, this.boxes);
    const on = <K extends keyof HTMLElementEventMap>(
      type: K,
      listen: (event: HTMLElementEventMap[K]) => void,
    ): void => this.canvas.addEventListener(type, listen, { passive: false });
    on('pointerdown', (event) => this.down(event));
    on('pointermove', (event) => this.move(event));
    on('pointerup', (event) => this.up(event));
    on('pointercancel', (event) => {
      this.cancel();
      this.up(event);
    });
    on('pointerleave', () => this.leave());
    on('wheel', (event) => this.wheel(event));
    on('dblclick', () => this.lasso.open && this.outlines.end());
    on('contextmenu', (event) => event.preventDefault());
  }

  /** Place of the brush on the surface, room coordinates; null off the recording. */
  get brushAt(): Vector3 | null {
    return this.light.at;
  }

  private down(event: PointerEvent): void {
    if (this.touches.down(event)) {
      // The first finger's press was the beginning of a pinch.
      this.cancel();
      this.drag = 'pinch';
    }
    if (this.drag) return;
    this.canvas.focus({ preventScroll: true });
    event.preventDefault();
    this.aim.place(event);
    this.drag = this.chooseDrag(event);
    if (this.drag) this.canvas.setPointerCapture(event.pointerId);
    this.last.x = event.offsetX;
    this.last.y = event.offsetY;
  }

  private chooseDrag(event: PointerEvent): Drag | null {
    if (event.button === 2) return this.pivotUnderCursor('pan');
    const removes = this.removes(event);
    if (event.button === 1 || (event.altKey && !removes)) return this.pivotUnderCursor('turn');
    if (event.button !== 0) return null;
    if (this.handles.grab()) return 'handle';
    if (this.lasso.open) {
      if (this.lasso.corner(this.aim.x, this.aim.y)) this.closeOutline();
      return null;
    }
    return this.useTool(event.pointerType === 'touch', removes);
  }

  private useTool(finger: boolean, removes: boolean): Drag | null {
    const tool = state.tool.peek();
    if (tool === 'boxes' && this.boxPress.begin()) return 'box';
    if (tool === 'boxes' || tool === 'navigate') return this.pivotUnderCursor('turn');
    return isStroke(tool) ? this.beginStroke(removes) : this.beginTap(finger);
  }

  private beginTap(finger: boolean): Drag | null {
    // A finger's tap counts when it is up: a second one may follow.
    if (finger) return 'tap';
    this.tap();
    return null;
  }

  /** Return whether a press removes points from an object. */
  private removes(event: PointerEvent): boolean {
    return event.altKey && event.button === 0 && this.clicksObjects();
  }

  private clicksObjects(): boolean {
    return isStroke(state.tool.peek()) && deskWay().samples === 'clicks';
  }

  private tap(): void {
    const label = state.tool.peek() === 'pick' ? this.aim.labelUnderCursor() : 0;
    if (label !== 0) actions.labels.selectLabel(label);
    if (state.tool.peek() === 'floor') void actions.view.pointAtFloor(this.aim.ray());
  }

  private pivotUnderCursor(drag: Drag): Drag {
    const hit = this.aim.hit(0.05);
    if (hit) this.deps.camera.pivot.copy(this.aim.roomPosition(hit));
    return drag;
  }

  private move(event: PointerEvent): void {
    const { x, y } = this.last;
    const pinch = this.touches.move(event);
    if (this.drag === 'pinch') {
      if (pinch) this.pinch(event, pinch);
      return;
    }
    this.aim.place(event);
    if (this.drag === 'turn') this.deps.camera.turn(event.offsetX - x, event.offsetY - y);
    if (this.drag === 'pan') {
      this.deps.camera.pan(event.offsetX - x, event.offsetY - y, this.canvas.clientHeight);
    }
    if (this.drag === 'stroke') {
      for (const part of event.getCoalescedEvents()) this.dabsTo(part.offsetX, part.offsetY);
      this.dabsTo(event.offsetX, event.offsetY);
    }
    if (this.drag === 'handle') this.handles.drag();
    if (this.drag === 'box') this.boxes.stretch();
    const draws = this.drag === 'lasso' || (this.drag === null && this.lasso.open);
    if (draws) this.lasso.add(event.offsetX, event.offsetY);
    this.last.x = event.offsetX;
    this.last.y = event.offsetY;
    this.deps.viewer.invalidate();
  }

  /** Two fingers: their middle moves the camera, their distance brings it closer. */
  private pinch(event: PointerEvent, { x, y, dx, dy, grown }: Pinch): void {
    this.aim.place(event);
    this.aim.x = x;
    this.aim.y = y;
    this.deps.camera.pan(dx, dy, this.canvas.clientHeight);
    this.zoom(Math.log(grown) * NOTCHES_PER_E);
  }

  /** Bring the camera closer to the place under the cursor. */
  private zoom(notches: number): void {
    const { camera, viewer } = this.deps;
    const hit = this.aim.hit(0.1);
    const target = hit ? this.aim.roomPosition(hit) : this.aim.ahead(camera.pivot);
    camera.zoom(notches, target);
    viewer.invalidate();
  }

  /** Cancel the stroke or outline in progress; false when there is none. */
  cancel(): boolean {
    const { drag } = this;
    const draft = this.boxes.drop();
    if (drag !== 'stroke' && drag !== 'lasso' && !this.lasso.open && !draft) return false;
    this.stroke?.cancel();
    this.stroke = null;
    this.lasso.cancel();
    this.drag = null;
    return true;
  }

  /** End a stroke and drop an outline: another frame is on screen, or other points may be painted. */
  interrupt(): void {
    if (this.drag === 'lasso' || this.lasso.open) this.cancel();
    if (this.drag !== 'stroke') return;
    this.stroke?.end();
    this.stroke = null;
    this.drag = null;
  }

  private up(event: PointerEvent): void {
    const more = this.touches.up(event);
    if (this.drag === 'tap') this.tap();
    if (this.drag === 'pinch' && more) return;
    this.finish();
    if (this.canvas.hasPointerCapture(event.pointerId)) {
      this.canvas.releasePointerCapture(event.pointerId);
    }
  }

  private finish(): void {
    if (this.drag === 'stroke') {
      this.stroke?.end();
      if (this.stroke && completes(deskWay())) {
        this.deps.objects.complete(this.path.samples(), this.stroke.id);
      }
      this.stroke = null;
    }
    if (this.drag === 'lasso') this.outlines.end();
    if (this.drag === 'box') this.boxPress.end();
    this.handles.release();
    this.drag = null;
  }

  /** Use the tool in the middle of the picture, as a click there does. */
  useInMiddle(): void {
    if (this.drag) return;
    this.aimAtMiddle();
    this.drag = this.useTool(false, false);
    this.finish();
  }

  private leave(): void {
    this.aim.inside = false;
    this.aim.moved = true;
    this.deps.viewer.invalidate();
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    this.aim.place(event);
    const notches = -event.deltaY / (event.deltaMode === 0 ? 100 : 3);
    if (event.altKey && scrollClip(Math.sign(notches))) return;
    // The wheel is the object's while it shows one or waits for it; with Ctrl it brings closer.
    if (this.clicksObjects() && !event.ctrlKey && this.turnLevels(notches)) return;
    const notch = event.ctrlKey && !event.metaKey && Math.abs(event.deltaY) >= 50;
    if (notch && !this.clicksObjects()) {
      actions.tools.nudgeRadius(Math.sign(notches));
      return;
    }
    this.zoom(event.ctrlKey ? notches * 4 : notches);
  }

  /** Whether the object tool takes the wheel; a touchpad sends parts of a notch: they add up. */
  private turnLevels(notches: number): boolean {
    this.turned += notches;
    const levels = Math.trunc(this.turned);
    const shows = this.deps.objects.step(levels);
    this.turned = shows ? this.turned - levels : 0;
    return shows || this.deps.objects.waits;
  }

  // ── strokes ────────────────────────────────────────────────────────────────────────────────

  private beginStroke(removes: boolean): Drag | null {
    const frame = this.aim.frame();
    const info = state.sequence.peek();
    if (!frame || !info) return null;
    const way = deskWay();
    const { radius } = state.brush.peek();
    if (way.name === 'box' && boxDraft.peek()) return this.pivotUnderCursor('turn');
    if (way.name !== 'lasso' && !this.aim.hit(radius)) return 'turn';
    const brush = brushFor(way, radius);
    if (!brush) return null;
    if (way.samples === 'clicks') {
      this.deps.objects.click(this.aim.ray(), removes);
      return null;
    }
    this.deps.objects.end();
    this.deps.regions.leave();
    if (way.name === 'box') return this.boxes.begin() ? 'box' : 'turn';
    if (way.samples === 'drawn') return this.beginOutline();
    this.stroke = this.deps.strokes.begin(frame, brush, info.shift);
    this.path.clear();
    this.sample(this.aim.ray());
    return 'stroke';
  }

  private beginOutline(): Drag | null {
    this.lasso.begin(this.aim.x, this.aim.y, brushColor());
    return outlineKind.peek() === 'polygon' ? null : 'lasso';
  }

  private sample(ray: PointerSample): void {
    this.path.add(ray);
    this.stroke?.add(ray);
  }

  /** Dabs between the last place and this one, close enough to make a line. */
  private dabsTo(x: number, y: number): void {
    if (!this.stroke || deskWay().samples !== 'path') return;
    const distance = Math.hypot(x - this.last.x, y - this.last.y);
    if (distance < 0.5) return;
    const pixel = this.aim.pixelAt(state.hover.peek()?.distance ?? 2);
    const gap = Math.max(2, (state.brush.peek().radius / pixel) * DAB_SPACING);
    const dabs = Math.min(MAX_DABS, Math.ceil(distance / gap));
    for (let i = 1; i <= dabs; i++) {
      const t = i / dabs;
      const { last } = this;
      this.sample(this.aim.ray(last.x + (x - last.x) * t, last.y + (y - last.y) * t));
    }
    this.last.x = x;
    this.last.y = y;
  }

  /** Close the polygon that is drawn, or take the box; false when there is neither. */
  closeOutline(): boolean {
    if (!this.lasso.open) return this.boxes.apply();
    this.outlines.end();
    return true;
  }

  /** Take back the last corner of the polygon that is drawn; false when there is none. */
  takeBackCorner(): boolean {
    return this.lasso.takeBack();
  }

  /** Put the box that is drawn on the ground; false when there is none. */
  snapBox(): boolean {
    return this.boxes.snap();
  }

  /** Put the brush into the middle of the picture. */
  aimAtMiddle(): void {
    this.aim.placeInMiddle();
    this.deps.viewer.invalidate();
  }

  /** Redraw the brush after a change of settings, although the mouse has not moved. */
  refresh(): void {
    this.aim.moved = true;
    this.lasso.changed ||= this.lasso.open;
    this.deps.viewer.invalidate();
  }

  /** Before each picture: light up the points under the brush. */
  update(): void {
    this.outlines.update();
    this.boxes.update();
    this.handles.update();
    if (!this.aim.moved) return;
    const turns = this.drag === 'turn' || this.drag === 'pan';
    const handle = turns ? null : (this.handles.under()?.handle ?? null);
    this.canvas.style.cursor = cursorOf(state.tool.peek(), deskWay(), handle, turns);
    if (turns) return;
    this.aim.moved = false;
    this.light.update();
    if (this.drag === null) this.askAhead();
  }

  /** Ask the server for the points that a click here would take. */
  private askAhead(): void {
    const { objects, regions } = this.deps;
    const way = deskWay();
    if (!isStroke(state.tool.peek()) || way.preview !== 'asked') return;
    const hit = this.aim.hit(state.brush.peek().radius);
    if (way.samples === 'clicks') {
      if (hit) objects.hover(this.aim.ray());
      else objects.leave();
    } else if (hit) regions.hover(this.aim.ray());
    else regions.leave();
  }
}
