/** Label id → colour and flags, as a texture: recolouring a label uploads nothing else. */
import { DataTexture, NearestFilter, RGBAFormat, UnsignedByteType } from 'three';
import { parseColor } from '../../common/colors';
import type { Label } from '../../protocol/messages';

const SIDE = 256;
/** Id of the points of a click's candidate: lighter than the label that they would get. */
export const PREVIEW = 65534;
/** The first id of the classes predicted for points: `SURE_STEPS` of each class, the surest last. */
export const PREDICTED = 65024;
export const MOST_CLASSES = 64;
export const SURE_STEPS = 4;
/** The first of the ids with the colours of sensors, which no point has. */
export const SENSORS = 65280;
/** Points of a place that is asked about: in their own colours, and in the headset they pulse. */
export const QUESTION_ID = 65344;
/** The first of the ids for labels of a copy, and for differences of two copies. */
export const OTHERS = 65345;
export const MOST_OTHERS = 128;
/** The first of the ids of found people before they are accepted: lighter, with an edge. */
export const FOUND = 65473;
export const MOST_FOUND = PREVIEW - FOUND;
/** Share of white in the preview's colour. */
const PREVIEW_WHITE = 0.45;
export const FLAG_VISIBLE = 128;
/** Strokes leave its points alone: it is locked, or hidden for all. */
export const FLAG_SPARED = 64;
/** A person should look at it: it pulses in the headset. */
export const FLAG_UNSURE = 32;
/** A classifier's prediction, not a label: drawn smaller and paler. */
export const FLAG_PREDICTED = 8;
/** Hidden for all, although it may be solo here. */
export const FLAG_HIDDEN = 16;

export class PaletteTexture {
  readonly texture: DataTexture;
  private readonly data = new Uint8Array(SIDE * SIDE * 4);

  constructor() {
    this.texture = new DataTexture(this.data, SIDE, SIDE, RGBAFormat, UnsignedByteType);
    this.texture.minFilter = NearestFilter;
    this.texture.magFilter = NearestFilter;
    this.texture.generateMipmaps = false;
    for (let id = PREDICTED; id < SIDE * SIDE; id++) this.data[4 * id + 3] = FLAG_VISIBLE;
    this.data.set([255, 255, 255, FLAG_VISIBLE | FLAG_PREDICTED | FLAG_UNSURE], QUESTION_ID * 4);
    this.set([], null, []);
  }

  /** `solo`: the only label shown, or null; `unsure`: labels that a person should check. */
  set(labels: readonly Label[], solo: number | null, unsure: readonly number[]): void {
    // A label that this page has not received yet is grey instead of invisible.
    for (let i = 0; i < 4 * PREDICTED; i += 4) {
      this.data[i] = this.data[i + 1] = this.data[i + 2] = 160;
      this.data[i + 3] = FLAG_VISIBLE;
    }
    for (const label of labels) {
      const visible = solo === null ? label.visible : solo === label.id;
      const flags =
        (visible ? FLAG_VISIBLE : 0) |
        (label.locked || !label.visible ? FLAG_SPARED : 0) |
        (label.visible ? 0 : FLAG_HIDDEN) |
        (unsure.includes(label.id) ? FLAG_UNSURE : 0);
      this.data.set([...parseColor(label.color), flags], label.id * 4);
    }
    this.texture.needsUpdate = true;
  }

  /** The colour that is previewed, "#rrggbb". */
  setPreview(color: string): void {
    this.paint(PREVIEW, [color], FLAG_VISIBLE, PREVIEW_WHITE);
  }

  /** Colours of found people, ids from `FOUND` on, "#rrggbb". */
  setFound(colors: readonly string[]): void {
    this.paint(FOUND, colors.slice(0, MOST_FOUND), FLAG_VISIBLE, PREVIEW_WHITE);
  }

  /** Set the colours of predictions, ids from `PREDICTED` on, "#rrggbb". */
  setPredicted(colors: readonly string[]): void {
    this.paint(PREDICTED, colors, FLAG_VISIBLE | FLAG_PREDICTED);
  }

  /** Colours of the ids from `OTHERS` on, "#rrggbb". */
  setOthers(colors: readonly string[]): void {
    this.paint(OTHERS, colors.slice(0, MOST_OTHERS), FLAG_VISIBLE);
  }

  /** Colours of the recording's sensors, "#rrggbb", and the numbers of hidden ones. */
  setSensors(colors: readonly string[], hidden: ReadonlySet<number>): void {
    colors.forEach((color, sensor) => {
      this.paint(SENSORS + sensor, [color], hidden.has(sensor) ? 0 : FLAG_VISIBLE);
    });
  }

  private paint(first: number, colors: readonly string[], flags: number, white = 0): void {
    colors.forEach((color, k) => {
      const mixed = parseColor(color).map((part) => Math.round(part + (255 - part) * white));
      this.data.set([...mixed, flags], (first + k) * 4);
    });
    this.texture.needsUpdate = true;
  }

  /** Whether it is shown, here and for all: rays meet its points. */
  isShown(id: number): boolean {
    return (this.data[id * 4 + 3]! & (FLAG_VISIBLE | FLAG_HIDDEN)) === FLAG_VISIBLE;
  }

  isSpared(id: number): boolean {
    return (this.data[id * 4 + 3]! & FLAG_SPARED) !== 0;
  }
}
