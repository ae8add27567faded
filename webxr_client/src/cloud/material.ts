/** The points' material: every slot draws with its own, all share one set of settings. */
import { DataTexture, FloatType, GLSL3, Matrix4, NearestFilter, RawShaderMaterial, RGBAFormat, Vector2, Vector3, Vector4 } from 'three'; // prettier-ignore
import type { IUniform } from 'three';
import type { ViewSettings } from '../state';
import { MAX_CHUNKS } from '../net/segment';
import { densityFactor, type CloudFrame } from './frame';
import { POINT_FRAGMENT, POINT_VERTEX } from './shaders';

const COLOR_MODES = { rgb: 0, intensity: 1, height: 2, plain: 3 } as const;

/** Points fill a surface when each is somewhat wider than the distance to the next. */
const FILL = 1.85;

/** Settings that all points share; the values are read at every draw. */
export class PointUniforms {
  readonly pixelsPerMetre = { value: 500 };
  readonly pixelLimits = { value: new Vector2(1.5, 48) };
  readonly colourMode = { value: 0 };
  readonly hasIntensity = { value: 0 };
  readonly heightRow = { value: new Vector4() };
  readonly gain = { value: 1 };
  readonly labelBlend = { value: 0.7 };
  readonly hideUnlabeled = { value: 0 };
  readonly showDeleted = { value: 0 };
  readonly brushMode = { value: 0 };
  readonly brushA = { value: new Vector3() };
  readonly brushB = { value: new Vector3() };
  readonly brushRadius = { value: 0.05 };
  readonly brushColour = { value: new Vector3(1, 1, 1) };
  readonly brushOnlyUnlabeled = { value: 0 };
  readonly pulse = { value: 0 };
  readonly palette: IUniform<DataTexture>;
  private pointSize = 1;

  constructor(palette: DataTexture) {
    this.palette = { value: palette };
  }

  set(view: ViewSettings, fields: readonly string[]): void {
    let mode = view.color;
    if (mode === 'rgb' && !fields.includes('rgb')) mode = 'intensity';
    if (mode === 'intensity' && !fields.includes('intensity')) mode = 'height';
    this.colourMode.value = COLOR_MODES[mode];
    this.hasIntensity.value = fields.includes('intensity') ? 1 : 0;
    this.pointSize = view.pointSize;
    // Brightness is a factor of light; colours are stored with a gamma of about 2.2.
    this.gain.value = view.brightness ** (1 / 2.2);
    this.labelBlend.value = view.labelBlend;
    this.hideUnlabeled.value = view.hideUnlabeled ? 1 : 0;
    this.showDeleted.value = view.showDeleted ? 1 : 0;
  }

  /** Height of the viewport that is drawn into, in pixels. */
  setViewport(height: number): void {
    this.pixelsPerMetre.value = (height / 2) * FILL * this.pointSize;
    const scale = Math.max(1, height / 900);
    this.pixelLimits.value.set(
      1.4 * scale * Math.min(1, this.pointSize),
      26 * scale * this.pointSize,
    );
  }

  /** The height ramp runs over the room's bounds. */
  setHeight(room: Matrix4, low: number, high: number): void {
    const e = room.elements;
    const span = Math.max(1e-3, high - low);
    this.heightRow.value.set(e[1] / span, e[5] / span, e[9] / span, (e[13] - low) / span);
  }
}

/** Origins and scales of a slot's chunks, one row each. */
export class ChunkTable {
  readonly texture: DataTexture;
  private readonly data = new Float32Array(MAX_CHUNKS * 8);

  constructor() {
    this.texture = new DataTexture(this.data, 2, MAX_CHUNKS, RGBAFormat, FloatType);
    this.texture.minFilter = NearestFilter;
    this.texture.magFilter = NearestFilter;
    this.texture.needsUpdate = true;
  }

  /** `shown`: points of the frame that are drawn. */
  set(frame: CloudFrame, shown: number): void {
    for (let i = 0; i < frame.pieces.length; i++) {
      const piece = frame.pieces[i]!;
      const at = (piece.index % MAX_CHUNKS) * 8;
      this.data.set(piece.origin, at);
      this.data[at + 3] = densityFactor(frame, piece, shown);
      this.data.set(piece.scale, at + 4);
    }
    this.texture.needsUpdate = true;
  }

  setRow(row: number, origin: readonly number[], scale: readonly number[], factor: number): void {
    this.data.set(origin, row * 8);
    this.data[row * 8 + 3] = factor;
    this.data.set(scale, row * 8 + 4);
    this.texture.needsUpdate = true;
  }
}

export function pointMaterial(
  shared: PointUniforms,
  table: ChunkTable,
  row: number,
): RawShaderMaterial {
  const {
    palette,
    pixelsPerMetre,
    pixelLimits,
    colourMode,
    hasIntensity,
    heightRow,
    gain,
    labelBlend,
  } = shared;
  const { hideUnlabeled, showDeleted, brushMode, brushA, brushB } = shared;
  const { brushRadius, brushColour, brushOnlyUnlabeled, pulse } = shared;
  return new RawShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: POINT_VERTEX,
    fragmentShader: POINT_FRAGMENT,
    uniforms: {
      chunkTable: { value: table.texture },
      chunkRow: { value: row },
      palette, pixelsPerMetre, pixelLimits, colourMode, hasIntensity, heightRow, gain, labelBlend,
      hideUnlabeled, showDeleted, brushMode, brushA, brushB,
      brushRadius, brushColour, brushOnlyUnlabeled, pulse,
    }, // prettier-ignore
  });
}
