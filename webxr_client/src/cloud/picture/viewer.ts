/** The picture: renderer, scene, and the GPU slots that frames are shown from. */
import { Box3, Group, type PerspectiveCamera, Scene, Vector2, Vector3, WebGLRenderer } from 'three'; // prettier-ignore
import type { SequenceInfo } from '../../protocol/messages';
import { Listeners, reportFailure } from '../../store/listeners';
import { state, type ViewSettings } from '../../store/state';
import { Afterwards } from './afterwards';
import { Backdrop } from './backdrop';
import { antialiasHeadset, isSoftware } from './context';
import { keepLists } from './slots/draw-order';
import { EyeDome } from './eyedome';
import { ALL_POINTS, type CloudFrame } from '../points/frame';
import { canReverse, reverseEyes, setPlanes, setReversed } from './headset-depth';
import { LargeCloud } from './large';
import { Lens } from './lens';
import type { PlacedFrame } from '../points/layer';
import { isPlain, type Mapping, PointUniforms } from './material';
import { PaletteTexture } from './palette';
import { PlacedFrames } from './slots/placed-frames';
import { Slots } from './slots/slots';
import { SurfaceChoice } from './lattice/surface-choice';
import { Timing } from './timing';
import { noPoints } from './warm-up';

/** Layers 1 and 2 are the headset's eyes. */
const POINTS_LAYER = 3;

export class Viewer {
  readonly renderer: WebGLRenderer;
  readonly scene = new Scene();
  readonly camera = new Lens(55, 1, 0.05, 500);
  /** Moved, turned and scaled by a person in the headset; identity at the desk. */
  readonly world = new Group();
  /** `T_room_local`: stands the recording on the floor. */
  readonly room = new Group();
  readonly backdrop = new Backdrop();
  readonly palette = new PaletteTexture();
  readonly uniforms = new PointUniforms(this.palette.texture);
  /** Run before each picture, in order, with its time and the headset's frame. */
  readonly ticks = new Listeners<number, XRFrame | undefined>();
  readonly afterwards = new Afterwards();
  /** Pictures drawn. */
  pictures = 0;
  /** CPU milliseconds, while measured: our own work before a picture, and three's to issue it. */
  readonly workMs = new Timing();
  readonly drawMs = new Timing();
  /** Milliseconds between pictures while something moves. */
  readonly intervalMs = new Timing();
  /** Off: pictures are prepared but not drawn, to measure all else. */
  drawing = true;
  /** The GPU is a program: pretty extras are left out unless asked for. */
  readonly software: boolean;
  private readonly eyeDome = new EyeDome();
  private readonly surface = new SurfaceChoice();
  private slots: Slots | null = null;
  private large: LargeCloud | null = null;
  private over: PlacedFrames | null = null;
  private info: SequenceInfo | null = null;
  private shown: CloudFrame | null = null;
  /** The ramps fit the recording; they do once it has points. */
  private fitted = false;
  private order: Parameters<LargeCloud['setOrder']> = [[], []];
  /** The headset's pictures have reversed depth. */
  readonly reversible: boolean;
  /** Of the recording, in the room. */
  readonly middle = new Vector3();
  /** The recording's diagonal, metres. */
  private extent = 0;
  private readonly outlined = new Set<string>();
  private questionShown = false;
  private dirty = true;
  private limit = ALL_POINTS;
  private measuring = false;
  private readonly size = new Vector2();

  constructor(readonly canvas: HTMLCanvasElement) {
    antialiasHeadset(canvas);
    this.renderer = new WebGLRenderer({
      canvas,
      antialias: false,
      powerPreference: 'high-performance',
    });
    this.renderer.autoClear = false;
    // Each question after a program's errors waits for the GPU: three of them for each program.
    this.renderer.debug.checkShaderErrors = import.meta.env.DEV;
    this.setUp();
    this.reversible = canReverse(this.renderer);
    this.software = isSoftware(this.renderer.getContext());
    this.world.add(this.room);
    this.room.matrixAutoUpdate = false;
    this.scene.add(
      this.backdrop.group,
      this.world,
      this.eyeDome.quad,
      noPoints(this.renderer, this.uniforms),
    );
    canvas.addEventListener('webglcontextlost', () => this.lose());
    canvas.addEventListener('webglcontextrestored', () => this.restore());
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
  }

  /** Settings that three.js keeps for one graphics context alone. */
  private setUp(): void {
    this.renderer.setClearColor(0x000000, 0);
    keepLists(this.renderer, this.scene);
  }

  start(): void {
    this.renderer.setAnimationLoop((now, frame) => this.tick(now, frame));
  }

  /** Draw again at the next opportunity: something changed. */
  invalidate(): void {
    this.dirty = true;
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0 || this.renderer.xr.isPresenting) return;
    const ratio = Math.min(window.devicePixelRatio, 2);
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.renderer.getDrawingBufferSize(this.size);
    this.eyeDome.setSize(this.size.x, this.size.y, ratio);
    this.invalidate();
  }

  /** Prepare for a recording: buffers for its largest frame, its place in the room. */
  setSequence(info: SequenceInfo | null): void {
    this.clear();
    this.info = info;
    if (!info) return;
    this.stand(info);
    const { renderer, uniforms, room } = this;
    if (info.large) {
      this.large = new LargeCloud(renderer, uniforms);
      this.large.group.traverse((object) => object.layers.set(POINTS_LAYER));
      room.add(this.large.group);
    } else {
      const capacity = Math.max(1, ...info.points);
      this.slots = new Slots(renderer, uniforms, info.frames, capacity, room, POINTS_LAYER);
      this.over = new PlacedFrames(renderer, uniforms, room, POINTS_LAYER);
    }
    this.cloud?.setLimit(this.limit);
  }

  /** Put the recording on its floor, which is as `info` says from now on. */
  stand(info: SequenceInfo): void {
    this.info = info;
    this.room.matrix.set(...(info.room as Parameters<typeof this.room.matrix.set>));
    this.room.matrixWorldNeedsUpdate = true;
    const [low, high] = this.bounds(info);
    const farthest = [0, 1, 2].map((k) => Math.max(Math.abs(info.lo[k]!), Math.abs(info.hi[k]!)));
    this.uniforms.setDistance(Math.hypot(...farthest));
    this.fitted = false;
    if (this.uniforms.normals) this.uniforms.normals = this.room.matrix.clone();
    if (this.shown) this.show(this.shown);
    this.backdrop.fit(Math.max(high.x - low.x, high.z - low.z));
    this.extent = low.distanceTo(high);
    this.middle.copy(low).add(high).multiplyScalar(0.5);
    this.invalidate();
  }

  /** Corners of the recording's bounds in the room. */
  bounds(info: SequenceInfo): [Vector3, Vector3] {
    const local = new Box3(new Vector3(...info.lo), new Vector3(...info.hi));
    const { min, max } = local.applyMatrix4(this.room.matrix);
    return [min, max];
  }

  private clear(): void {
    this.release();
    this.shown = null;
    this.invalidate();
  }

  private release(): void {
    this.cloud?.dispose();
    this.over?.dispose();
    this.slots = this.large = this.over = null;
  }

  /** The GPU lost everything it held: nothing is drawn until the context is restored. */
  private lose(): void {
    state.pictureLost.value = true;
    this.release();
  }

  /** Make the buffers anew, and show the frame again in the same colours. */
  private restore(): void {
    const { shown, fitted } = this;
    this.setUp();
    this.setSequence(this.info);
    this.large?.setOrder(...this.order);
    this.fitted = fitted;
    if (shown) this.show(shown);
    state.pictureLost.value = false;
  }

  setView(view: ViewSettings, fields: readonly string[]): void {
    this.uniforms.set(view, fields);
    this.showNormals(view.color === 'normal');
    this.eyeDome.shade(view.eyeDome, isPlain(view.color));
    this.surface.mode = view.surface;
    this.backdrop.showFloor(view.grid);
    this.invalidate();
  }

  /** Colour points by their normals, or not; normals are computed for the frame on screen. */
  private showNormals(on: boolean): void {
    const { uniforms, room, shown } = this;
    if (on === (uniforms.normals !== null)) return;
    uniforms.normals = on ? room.matrix.clone() : null;
    if (shown) this.cloud?.update(shown);
  }

  /** Choose the colours of points; `questionShown`: points of a question have an edge. */
  setMapping(mapping: Mapping, questionShown: boolean): void {
    this.questionShown = questionShown;
    this.uniforms.mapping = mapping;
    this.eyeDome.setFlat(mapping === 'classes');
    this.invalidate();
  }

  /** Draw the edge of points of a candidate, as long as one of its purposes asks for it. */
  setOutlined(purpose: string, on: boolean): void {
    if (on) this.outlined.add(purpose);
    else this.outlined.delete(purpose);
    this.invalidate();
  }

  /** Objects that show the recording. */
  private get cloud(): Slots | LargeCloud | null {
    return this.slots ?? this.large;
  }

  /** Show a frame as it is now. */
  show(frame: CloudFrame): void {
    this.shown = frame;
    this.fitted ||= this.uniforms.fit(frame, this.room.matrix);
    this.uniforms.setPoints(frame.total);
    this.cloud?.update(frame);
    this.invalidate();
  }

  /**
   * Set the order of a large frame's chunks, the most important for the view first: a limit draws
   * the first ones.  `parents`: for each chunk the one above it in the octree, −1 at the root.
   */
  setOrder(order: readonly number[], parents: readonly number[]): void {
    this.order = [order, parents];
    this.large?.setOrder(order, parents);
    this.invalidate();
  }

  /** Draw at most about so many points of a frame. */
  setLimit(points: number): void {
    if (points === this.limit) return;
    this.limit = points;
    const before = this.drawn;
    this.cloud?.setLimit(points);
    this.over?.setLimit(points);
    if (this.drawn === before) return;
    // The next picture takes another time, which is unrelated to the previous one.
    this.intervalMs.interrupt();
    this.dirty = true;
  }

  /** Height of one eye's picture, in pixels. */
  get viewHeight(): number {
    const { xr } = this.renderer;
    return xr.isPresenting ? xr.getCamera().cameras[0].viewport.w : this.size.y;
  }

  /** Bring a frame to the GPU ahead of time. */
  prepare(frame: CloudFrame): void {
    this.slots?.prepare(frame);
  }

  /** Lay frames over the one on screen, and no others; true when the picture changes. */
  lay(frames: readonly PlacedFrame[]): boolean {
    return this.over?.show(frames) ?? false;
  }

  /** Points on screen of frames laid over the frame. */
  get laid(): number {
    return this.over?.drawn ?? 0;
  }

  /** Points on screen. */
  get drawn(): number {
    return this.cloud?.drawn ?? 0;
  }

  /** Points on screen with each label. */
  countLabels(): Map<number, number> {
    return this.slots?.countLabels() ?? new Map<number, number>();
  }

  private tick(now: number, frame: XRFrame | undefined): void {
    const { measuring } = this;
    const started = measuring ? performance.now() : 0;
    this.ticks.run(now, frame);
    const presenting = this.renderer.xr.isPresenting;
    if (!this.dirty && !presenting) {
      this.intervalMs.interrupt();
      return;
    }
    if (!this.drawing) return;
    this.dirty = false;
    this.pictures += 1;
    const worked = measuring ? performance.now() : 0;
    this.draw(presenting);
    if (measuring) {
      this.workMs.add(worked - started);
      this.drawMs.add(performance.now() - worked);
    }
    this.intervalMs.mark(now);
  }

  /** Report a picture that cannot be drawn; the loop continues with the next one. */
  private draw(presenting: boolean): void {
    try {
      if (presenting) this.drawHeadset();
      else this.drawDesk();
    } catch (error) {
      reportFailure(error);
    }
  }

  /** Measure times from now on, or not: each reading of the clock allocates a number. */
  measure(on: boolean): void {
    this.measuring = this.afterwards.measuring = on;
    if (!on) return;
    for (const timing of [this.workMs, this.drawMs, this.afterwards.ms, this.intervalMs]) {
      timing.reset();
    }
  }

  /** Draw the frame as a surface or as points, by how near an eye is. */
  private chooseSurface(camera: PerspectiveCamera): void {
    const { uniforms, shown, room } = this;
    const on = this.surface.update(shown?.images ?? [], camera, room.matrixWorld, this.viewHeight);
    if (on === uniforms.surface) return;
    uniforms.surface = on;
    this.slots?.showSurface(on);
  }

  /** The frame on screen is drawn as a surface. */
  get hasSurface(): boolean {
    return this.uniforms.surface;
  }

  private drawHeadset(): void {
    const eyes = this.renderer.xr.getCamera().cameras;
    this.chooseSurface(eyes[0]);
    this.uniforms.setViewport(eyes[0].viewport.w);
    this.uniforms.setOutlining(false);
    setPlanes(this.camera, this.extent * this.world.scale.x, this.reversible);
    setReversed(this.renderer, this.reversible);
    if (this.reversible) reverseEyes(eyes);
    this.eyeDome.quad.visible = false;
    this.camera.layers.enableAll();
    this.renderer.clear();
    this.renderer.render(this.scene, this.camera);
  }

  private drawDesk(): void {
    const { renderer, camera, eyeDome } = this;
    setReversed(renderer, false);
    this.uniforms.setViewport(this.size.y);
    camera.updateMatrixWorld();
    this.room.updateWorldMatrix(true, false);
    this.chooseSurface(camera);
    this.backdrop.follow(camera.position);
    eyeDome.quad.visible = false;
    const outlined = this.outlined.size > 0 || this.questionShown;
    const aside = (eyeDome.shades || outlined) && this.shown !== null;
    this.uniforms.setOutlining(aside && outlined);
    if (aside) {
      eyeDome.setCamera(camera);
      eyeDome.outline(outlined);
      renderer.setRenderTarget(eyeDome.target);
      renderer.clear();
      camera.layers.set(POINTS_LAYER);
      renderer.render(this.scene, camera);
      renderer.setRenderTarget(null);
      eyeDome.quad.visible = true;
      camera.layers.set(0);
    } else {
      camera.layers.set(0);
      camera.layers.enable(POINTS_LAYER);
    }
    renderer.clear();
    renderer.render(this.scene, camera);
  }
}
