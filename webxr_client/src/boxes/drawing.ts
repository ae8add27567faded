/** Boxes in the cloud: wireframes in their labels' colours, fronts marked, the chosen one with its name. */
import {
  BufferAttribute,
  BufferGeometry,
  CanvasTexture,
  DoubleSide,
  Group,
  Mesh,
  MeshBasicMaterial,
  Points,
  PointsMaterial,
  Sprite,
  SpriteMaterial,
} from 'three';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
import { parseColor } from '../common/colors';
import { free } from '../common/free';
import { HANDLES } from './grip';
import { placeOn, type Shape, type Side } from './shape';

/** Pixels across a line, of the chosen box and of others. */
const [BOLD, THIN] = [3, 1.6];
/** Metres of a dash and of the gap after it, for boxes that were not drawn by a person. */
const [DASH, GAP] = [0.22, 0.14];
/** Opacity of a front, of the chosen box and of others. */
const [FRONT_CHOSEN, FRONT] = [0.3, 0.14];
/** A name's height, of the height of the view. */
const NAME = 0.035;

/** A box as it is drawn; local coordinates. */
export interface Drawn {
  readonly shape: Shape;
  /** "#rrggbb". */
  readonly color: string;
  readonly name: string;
  readonly chosen: boolean;
  /** It was fitted or imported, not drawn. */
  readonly dashed: boolean;
  /** 0..1: boxes of less confidence are fainter. */
  readonly confidence: number;
  /** Its front is known, and marked. */
  readonly headed: boolean;
}

type Corner = readonly [Side, Side, Side];
const CORNERS: readonly Corner[] = [0, 1, 2, 3, 4, 5, 6, 7].map((bits): Corner => [
  bits & 1 ? 1 : -1,
  bits & 2 ? 1 : -1,
  bits & 4 ? 1 : -1,
]);
/** Corners two and two, by the bits of their numbers. */
export const EDGES = [0, 1, 2, 3, 4, 5, 6, 7, 0, 2, 1, 3, 4, 6, 5, 7, 0, 4, 1, 5, 2, 6, 3, 7];
/** The front's corners as two triangles. */
const FACE = [1, 3, 7, 1, 7, 5];

/** Ends of the lines of a box, two and two: its edges, and an arrow on its roof to a known front. */
export function linesOf(shape: Shape, headed: boolean): number[] {
  const corners = CORNERS.map((sides) => placeOn(shape, sides));
  const edges = EDGES.flatMap((k) => [...corners[k]!]);
  if (!headed) return edges;
  const top = placeOn(shape, [0, 0, 1]);
  const tip = placeOn(shape, [1, 0, 1]);
  const barb = (side: Side): number[] => {
    const corner = placeOn(shape, [1, side, 1]);
    // Half way back from the tip towards the middle, a quarter of the width aside.
    return [0, 1, 2].map((k) => (tip[k]! + top[k]!) / 2 + (corner[k]! - tip[k]!) / 2);
  };
  return [...edges, ...top, ...tip, ...tip, ...barb(1), ...tip, ...barb(-1)];
}

type Part =
  LineSegments2 | Mesh<BufferGeometry, MeshBasicMaterial> | Points<BufferGeometry, PointsMaterial>;

export class BoxWires {
  readonly group = new Group();
  private readonly name = new NameSign();
  /** Whether the places by which hands hold the chosen box are shown. */
  grips = false;
  private parts: Part[] = [];

  constructor() {
    this.group.add(this.name.sprite);
  }

  show(boxes: readonly Drawn[]): void {
    for (const part of this.parts) free(part);
    this.parts = boxes.filter(({ headed }) => headed).map(front);
    for (const dashed of [false, true]) {
      for (const chosen of [false, true]) {
        const some = boxes.filter((box) => box.dashed === dashed && box.chosen === chosen);
        if (some.length > 0) this.parts.push(wires(some, dashed, chosen));
        if (some.length > 0 && chosen) this.parts.push(behind(wires(some, dashed, chosen)));
      }
    }
    const chosen = boxes.find((box) => box.chosen);
    if (this.grips && chosen) this.parts.push(gripsOf(chosen));
    if (this.parts.length > 0) this.group.add(...this.parts);
    this.name.show(chosen ?? null);
  }
}

/** Pixels across a grip. */
const GRIP = 16;

function gripsOf({ shape }: Drawn): Points<BufferGeometry, PointsMaterial> {
  const places = Float32Array.from(HANDLES.flatMap((sides) => [...placeOn(shape, sides)]));
  const geometry = new BufferGeometry().setAttribute('position', new BufferAttribute(places, 3));
  const look = { size: GRIP, sizeAttenuation: false, depthTest: false, transparent: true };
  const points = new Points(geometry, new PointsMaterial({ ...look, toneMapped: false }));
  points.frustumCulled = false;
  points.renderOrder = 21;
  return points;
}

function linearRgb(color: string): number[] {
  return parseColor(color).map((channel) => (channel / 255) ** 2.2);
}

function wires(boxes: readonly Drawn[], dashed: boolean, chosen: boolean): LineSegments2 {
  const places = boxes.map(({ shape, headed }) => linesOf(shape, headed));
  const colours = boxes.flatMap(({ color, confidence }, i) => {
    const faint = 0.45 + 0.55 * confidence;
    const mixed = linearRgb(color).map((channel) => channel * faint);
    return Array.from({ length: places[i]!.length / 3 }, () => mixed).flat();
  });
  const geometry = new LineSegmentsGeometry();
  geometry.setPositions(places.flat());
  geometry.setColors(colours);
  const material = new LineMaterial({
    linewidth: chosen ? BOLD : THIN,
    vertexColors: true,
    dashed,
    dashSize: DASH,
    gapSize: GAP,
    transparent: true,
    toneMapped: false,
  });
  const lines = new LineSegments2(geometry, material);
  if (dashed) lines.computeLineDistances();
  lines.frustumCulled = false;
  lines.renderOrder = chosen ? 11 : 10;
  return lines;
}

/** Opacity of the chosen box behind points. */
const BEHIND = 0.3;

/** Lines that are seen through all that is before them. */
function behind(lines: LineSegments2): LineSegments2 {
  lines.material.depthTest = false;
  lines.material.opacity = BEHIND;
  return lines;
}

function front({ shape, color, chosen }: Drawn): Mesh<BufferGeometry, MeshBasicMaterial> {
  const corners = CORNERS.map((sides) => placeOn(shape, sides));
  const places = Float32Array.from(FACE.flatMap((k) => [...corners[k]!]));
  const geometry = new BufferGeometry().setAttribute('position', new BufferAttribute(places, 3));
  const material = new MeshBasicMaterial({
    color,
    transparent: true,
    opacity: chosen ? FRONT_CHOSEN : FRONT,
    side: DoubleSide,
    depthWrite: false,
    toneMapped: false,
  });
  const mesh = new Mesh(geometry, material);
  mesh.frustumCulled = false;
  return mesh;
}

/** Over the chosen box. */
class NameSign {
  readonly sprite = new Sprite(
    new SpriteMaterial({ depthTest: false, sizeAttenuation: false, transparent: true }),
  );
  private text = '';

  show(box: Drawn | null): void {
    this.sprite.visible = box !== null;
    if (!box) return;
    const { size, centre } = box.shape;
    const high = Math.hypot(...size) / 2;
    const up = placeOn(box.shape, [0, 0, 1]);
    const share = 1 + (0.25 * high) / (size[2] / 2);
    const [x, y, z] = centre.map((at, k) => at + (up[k]! - at) * share);
    this.sprite.position.set(x!, y!, z);
    this.sprite.renderOrder = 80;
    this.write(box);
  }

  private write({ name, color }: Drawn): void {
    const text = `${color} ${name}`;
    if (text === this.text) return;
    this.text = text;
    const canvas = signOf(name, color);
    const { material } = this.sprite;
    material.map?.dispose();
    material.map = new CanvasTexture(canvas);
    material.needsUpdate = true;
    this.sprite.scale.set((NAME * canvas.width) / canvas.height, NAME, 1);
  }
}

/** Pixels of a sign's letters, and of the room around them. */
const [LETTERS, PAD] = [34, 14];

function signOf(name: string, color: string): HTMLCanvasElement {
  const canvas = document.createElement('canvas');
  const pen = canvas.getContext('2d')!;
  const font = `600 ${LETTERS}px "Inter Variable", sans-serif`;
  pen.font = font;
  canvas.width = Math.ceil(pen.measureText(name).width) + 4 * PAD;
  canvas.height = LETTERS + 2 * PAD;
  pen.font = font;
  pen.fillStyle = 'rgb(13 16 20 / 85%)';
  pen.beginPath();
  pen.roundRect(0, 0, canvas.width, canvas.height, PAD);
  pen.fill();
  pen.fillStyle = color;
  pen.fillRect(PAD, PAD, PAD / 2, LETTERS);
  pen.fillStyle = '#ffffff';
  pen.textBaseline = 'middle';
  pen.fillText(name, 2.4 * PAD, canvas.height / 2 + 2);
  return canvas;
}
