/** The points' material: every slot draws with its own, all share one set of settings. */
import { Box2, DataTexture, DoubleSide, FloatType, GLSL3, Matrix4, NearestFilter, RawShaderMaterial, RGBAFormat, Vector2 } from 'three'; // prettier-ignore
import type { Color, IUniform, Vector3, WebGLRenderer } from 'three';
import type { ColorMode, ViewSettings } from '../../store/state';
import { MAX_CHUNKS } from '../../net/chunk/segment';
import { writeDensity, type CloudFrame } from '../points/frame';
import type { PlacedFrame } from '../points/layer';
import type { Piece } from '../points/piece';
import { spreadOf, type Range } from '../points/spread';
import { DOT_VERTEX, PLAIN_FRAGMENT, POINT_FRAGMENT, POINT_VERTEX, SETTING_ROWS } from './shaders';

/** Numbers of the modes in the shader; the modes of one number colour labels only. */
const COLOR_MODES = {
  rgb: 0,
  intensity: 1,
  height: 2,
  plain: 3,
  distance: 4,
  normal: 5,
  label: 6,
  confidence: 6,
  provenance: 6,
  sensor: 7,
} as const;
const RAMPS = { even: 0, grey: 1, rainbow: 2 } as const;

/** Return the mode of a recording with these fields when `wanted` is asked for. */
export function colorModeOf(wanted: ColorMode, fields: readonly string[]): ColorMode {
  let mode = wanted;
  if (mode === 'sensor' && !fields.includes('sensor')) mode = 'rgb';
  if (mode === 'rgb' && !fields.includes('rgb')) mode = 'intensity';
  if (mode === 'intensity' && !fields.includes('intensity')) mode = 'height';
  return mode;
}

/** Colours of the view; classes shaded by height and intensity; or the recording's colours alone. */
const MAPPINGS = ['view', 'classes', 'natural'] as const;
export type Mapping = (typeof MAPPINGS)[number];

/** Whether points without labels have next to no colours, so that depth alone shows shapes. */
export function isPlain(mode: ColorMode): boolean {
  return mode === 'plain' || COLOR_MODES[mode] === COLOR_MODES.label;
}

/** Points fill a surface when each is somewhat wider than the distance to the next. */
const FILL = 1.85;
/** Pixels of the widest discs, which fill near surfaces, and points of a frame that has surfaces to fill. */
const [WIDEST, FILLING] = [26, 50_000];
/** Part of that width that discs of the sparsest frames may have: wider ones would only hide others. */
const LEAST_WIDTH = 0.35;

/** Rows of the shader's array in `PointUniforms.settings`. */
const [PIXELS_PER_METRE, PIXEL_LIMITS, GAIN] = [0, 1, 3];
const [COLOUR_MODE, HAS_INTENSITY, LABEL_BLEND, HIDE_UNLABELED] = [4, 5, 6, 7];
const HEIGHT_ROW = 8;
const [BRUSH_A, BRUSH_RADIUS, BRUSH_B, BRUSH_MODE] = [12, 15, 16, 19];
const [DISTANCE_SCALE, RAMP_LOW, RAMP_SCALE, RAMP_KIND, SURFACE] = [31, 32, 33, 34, 35];
const [INTENSITY_FIT, MAPPING, SEVERAL_SENSORS] = [36, 38, 39];
const CLIP = 40;
const [BRUSH_COLOUR, ONLY_UNLABELED, SHOW_DELETED, PULSE] = [20, 23, 24, 25];
const [HALF_HEIGHT, OUTLINING] = [26, 27];

/** Region that the brush lights up: a ball, or the surroundings of a half-line. */
const [NONE, BALL, RAY] = [0, 1, 2];

/**
 * Settings that all points share, read at every draw.  One array of numbers for all: three.js hands
 * it on as it is, while each number or vector of its own would be boxed and compared.
 */
export class PointUniforms {
  readonly settings = { value: new Float32Array(4 * SETTING_ROWS) };
  readonly palette: IUniform<DataTexture>;
  /** The room with the axes for colours of normals; null: points have their own colours. */
  normals: Matrix4 | null = null;
  private pointSize = 1;
  private widest = WIDEST;

  constructor(palette: DataTexture) {
    this.palette = { value: palette };
    const { value } = this.settings;
    value.fill(1, BRUSH_COLOUR, BRUSH_COLOUR + 3);
    value[GAIN] = value[INTENSITY_FIT] = 1;
    this.setViewport(500);
  }

  set(view: ViewSettings, fields: readonly string[]): void {
    const { value } = this.settings;
    value[COLOUR_MODE] = COLOR_MODES[colorModeOf(view.color, fields)];
    value[HAS_INTENSITY] = fields.includes('intensity') ? 1 : 0;
    this.pointSize = view.pointSize;
    // Brightness is a factor of light; colours are stored with a gamma of about 2.2.
    value[GAIN] = view.brightness ** (1 / 2.2);
    value[LABEL_BLEND] = COLOR_MODES[view.color] === COLOR_MODES.label ? 1 : view.labelBlend;
    value[RAMP_LOW] = view.rampLow;
    value[RAMP_SCALE] = 1 / Math.max(0.01, view.rampHigh - view.rampLow);
    value[RAMP_KIND] = RAMPS[view.ramp];
    value[HIDE_UNLABELED] = view.hideUnlabeled ? 1 : 0;
    value[SHOW_DELETED] = view.showDeleted ? 1 : 0;
  }

  /** Fit the widest discs to a frame of so many points. */
  setPoints(points: number): void {
    this.widest = WIDEST * Math.min(1, Math.max(LEAST_WIDTH, Math.sqrt(points / FILLING)));
  }

  /** Height of the viewport that is drawn into, in pixels. */
  setViewport(height: number): void {
    const { value } = this.settings;
    const scale = Math.max(1, height / 900);
    value[PIXELS_PER_METRE] = (height / 2) * FILL * this.pointSize;
    value[HALF_HEIGHT] = height / 2;
    value[PIXEL_LIMITS] = 1.4 * scale * Math.min(1, this.pointSize);
    value[PIXEL_LIMITS + 1] = this.widest * scale * this.pointSize;
  }

  /** Fit the ramps to the values of a frame in the room; false without points. */
  fit(frame: CloudFrame, room: Matrix4): boolean {
    const spread = spreadOf(frame, room);
    if (!spread) return false;
    this.setHeight(room, spread.height);
    this.setIntensity(spread.intensity);
    return true;
  }

  /** The intensity ramp runs over these values, 0..1. */
  private setIntensity([low, high]: Range): void {
    const span = Math.max(1 / 255, high - low);
    this.settings.value[INTENSITY_FIT] = 1 / span;
    this.settings.value[INTENSITY_FIT + 1] = -low / span;
  }

  /** The height ramp runs over these heights, metres of the room. */
  private setHeight(room: Matrix4, [low, high]: Range): void {
    const e = room.elements;
    const span = Math.max(1e-3, high - low);
    this.settings.value.set([e[1] / span, e[5] / span, e[9] / span, (e[13] - low) / span], HEIGHT_ROW); // prettier-ignore
  }

  /** The distance ramp runs from each point's sensor to the greatest distance, metres. */
  setDistance(greatest: number): void {
    this.settings.value[DISTANCE_SCALE] = 1 / Math.max(1e-3, greatest);
  }

  /** Light up the points in a ball, local coordinates and metres. */
  lightBall(middle: Vector3, radius: number): void {
    const { value } = this.settings;
    middle.toArray(value, BRUSH_A);
    middle.toArray(value, BRUSH_B);
    value[BRUSH_RADIUS] = radius;
    value[BRUSH_MODE] = BALL;
  }

  /** Light up the points so near to a half-line. */
  lightRay(origin: Vector3, direction: Vector3, radius: number): void {
    const { value } = this.settings;
    origin.toArray(value, BRUSH_A);
    direction.toArray(value, BRUSH_B);
    value[BRUSH_RADIUS] = radius;
    value[BRUSH_MODE] = RAY;
  }

  /** Draw only points in a clip box: `T_cube_local`; null: all points. */
  setClip(matrix: Matrix4 | null): void {
    const { value } = this.settings;
    value.fill(0, CLIP, CLIP + 12);
    if (matrix) value.set(matrix.clone().transpose().elements.slice(0, 12), CLIP);
  }

  lightNothing(): void {
    this.settings.value[BRUSH_MODE] = NONE;
  }

  /** The brush's light, with gamma as points are stored. */
  setBrushColour({ r, g, b }: Color): void {
    const { value } = this.settings;
    value[BRUSH_COLOUR] = r;
    value[BRUSH_COLOUR + 1] = g;
    value[BRUSH_COLOUR + 2] = b;
  }

  get mapping(): Mapping {
    return MAPPINGS[this.settings.value[MAPPING]!]!;
  }

  set mapping(mapping: Mapping) {
    this.settings.value[MAPPING] = MAPPINGS.indexOf(mapping);
  }

  /** Points have the colours of their sensors, and hidden sensors' points are left out. */
  setSeveralSensors(on: boolean): void {
    this.settings.value[SEVERAL_SENSORS] = on ? 1 : 0;
  }

  /** Points that have a label are not lit. */
  setOnlyUnlabeled(on: boolean): void {
    this.settings.value[ONLY_UNLABELED] = on ? 1 : 0;
  }

  /** Mark the points of a click's candidate by their alpha. */
  setOutlining(on: boolean): void {
    this.settings.value[OUTLINING] = on ? 1 : 0;
  }

  /** Depth images are drawn as surfaces; points remain where they make none. */
  get surface(): boolean {
    return this.settings.value[SURFACE] === 1;
  }

  set surface(on: boolean) {
    this.settings.value[SURFACE] = on ? 1 : 0;
  }

  /** Emphasis of labels that a person should look at, 0..1. */
  get pulse(): number {
    return this.settings.value[PULSE]!;
  }

  set pulse(strength: number) {
    this.settings.value[PULSE] = strength;
  }

  /** The ball that is lit, or null. */
  get lit(): { middle: number[]; radius: number } | null {
    const { value } = this.settings;
    if (value[BRUSH_MODE] !== BALL) return null;
    return { middle: [...value.subarray(BRUSH_A, BRUSH_A + 3)], radius: value[BRUSH_RADIUS]! };
  }
}

/** Numbers of a row of a chunk table: three texels. */
const ROW = 12;

/** Origins and scales of a slot's chunks, and the places of their sensors, one row each. */
export class ChunkTable {
  readonly texture: DataTexture;
  private readonly data = new Float32Array(MAX_CHUNKS * ROW);
  /** The same memory: three.js copies from a texture that it has not uploaded itself. */
  private readonly source: DataTexture;
  /** The rows that changed. */
  private readonly changed = new Box2(new Vector2(), new Vector2(ROW / 4, 0));

  constructor(private readonly renderer: WebGLRenderer) {
    this.texture = table(this.data);
    this.texture.needsUpdate = true;
    this.source = table(this.data);
  }

  /** `shown`: points of the frame that are drawn. */
  set(frame: CloudFrame, shown: number): void {
    for (let i = 0; i < frame.pieces.length; i++) {
      const piece = frame.pieces[i]!;
      const row = piece.index % MAX_CHUNKS;
      this.place(row, piece);
      writeDensity(this.data, row * ROW + 3, frame, piece, shown);
    }
    this.upload();
  }

  setRow(row: number, piece: Piece, factor: number): void {
    this.place(row, piece);
    this.data[row * ROW + 3] = factor;
  }

  private place(row: number, { origin, scale, sensor, eye }: Piece): void {
    const { data } = this;
    const { min, max } = this.changed;
    data[row * ROW + 7] = sensor;
    for (let k = 0; k < 3; k++) {
      data[row * ROW + k] = origin[k]!;
      data[row * ROW + 4 + k] = scale[k]!;
      data[row * ROW + 8 + k] = eye[k]!;
    }
    if (max.y === 0 || row < min.y) min.y = row;
    if (row >= max.y) max.y = row + 1;
  }

  /** Bring the rows that changed to the GPU. */
  upload(): void {
    const { min, max } = this.changed;
    if (max.y === 0) return;
    this.renderer.copyTextureToTexture(this.source, this.texture, this.changed, min);
    min.y = max.y = 0;
  }

  dispose(): void {
    this.texture.dispose();
  }
}

/** Labels of one frame that lie elsewhere than the rest of it. */
const MOST_MOVING = 64;

/** Placement of a frame that is laid over the one on screen. */
export class Placement {
  readonly uniforms: Record<'placed' | 'moving' | 'movingCount', IUniform>;
  private readonly data = new Float32Array(MOST_MOVING * 16);
  private readonly texture = table(this.data, 4, MOST_MOVING);

  constructor() {
    this.uniforms = {
      placed: { value: new Matrix4() },
      moving: { value: this.texture },
      movingCount: { value: 0 },
    };
  }

  set({ placed, moving }: PlacedFrame): void {
    const rows = [...moving].slice(0, MOST_MOVING);
    rows.forEach(([label, T], row) => {
      this.data.set(T.clone().transpose().elements.slice(0, 12), row * 16);
      this.data[row * 16 + 12] = label;
    });
    this.texture.needsUpdate = true;
    this.uniforms.placed.value = placed;
    this.uniforms.movingCount.value = rows.length;
  }

  dispose(): void {
    this.texture.dispose();
  }
}

function table(data: Float32Array<ArrayBuffer>, width = ROW / 4, rows = MAX_CHUNKS): DataTexture {
  const texture = new DataTexture(data, width, rows, RGBAFormat, FloatType);
  texture.minFilter = NearestFilter;
  texture.magFilter = NearestFilter;
  return texture;
}

export function pointMaterial(
  uniforms: PointUniforms,
  table: ChunkTable,
  row: number,
  placement: Placement | null = null,
): RawShaderMaterial {
  const own = { chunkTable: { value: table.texture }, chunkRow: { value: row } };
  return cloudMaterial(uniforms, own, {}, placement);
}

/** Of points, or with `SURFACE` among the `defines` of triangles. */
export function cloudMaterial(
  { settings, palette }: PointUniforms,
  own: Record<string, IUniform>,
  defines: Record<string, number>,
  placement: Placement | null,
): RawShaderMaterial {
  return new RawShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: POINT_VERTEX,
    fragmentShader: 'SURFACE' in defines ? PLAIN_FRAGMENT : POINT_FRAGMENT,
    defines: placement ? { ...defines, PLACED: 1 } : defines,
    uniforms: { ...placement?.uniforms, ...own, palette, settings },
    side: DoubleSide,
  });
}

/** Dots so many metres wide, which are not points of the recording. */
export function dotMaterial({ settings }: PointUniforms, size: number): RawShaderMaterial {
  return new RawShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: DOT_VERTEX,
    fragmentShader: PLAIN_FRAGMENT,
    defines: { SIZE: size.toFixed(4) },
    uniforms: { settings },
    transparent: true,
    depthWrite: false,
  });
}
