/** Hints beside the controller for each button, until it has been used a few times. */
import { BufferAttribute, CanvasTexture, Mesh, MeshBasicMaterial, PlaneGeometry, SRGBColorSpace, type BufferGeometry, type Vector3 } from 'three'; // prettier-ignore
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import { faceEyes, type Facing } from './facing';
import { tipsFor, type Lessons, type Part, type Tip } from './lessons';
import type { Pointer } from './pointer';
import { SIZES } from './sizes';
import { tint } from './tint';
import { FONT, INK } from './ui';

const FADE_PER_SECOND = 2;
const PIXELS = 48;
/** Ems: from one line to the next, a line's own height, and the room beside its text. */
const [PITCH, HEIGHT, PAD] = [1.95, 1.75, 0.6];
/** Metres from the middle of the hand to the words. */
const BESIDE = 0.035;
const VERTICES = 4;

/** All words of a hand on one plate: each line fades by its own vertices' opacity. */
export class Tips {
  private tips: readonly Tip[] = [];
  private opacity = new Float64Array(0);
  private mesh: Mesh<BufferGeometry, MeshBasicMaterial> | null = null;
  private facing: Facing = { right: 0, up: 0, away: SIZES.tips.away };

  constructor(
    private readonly lessons: Lessons,
    private readonly hand: Pointer,
  ) {}

  /** Write anew what the hand's buttons do. */
  set(part: Part): void {
    this.clear();
    const { hand } = this;
    this.tips = tipsFor(hand.device, part, hand.side === 'left');
    this.opacity = new Float64Array(this.tips.length).fill(1);
    this.mesh = plate(this.tips, hand.side === 'left' ? -1 : 1);
    hand.grip.parent?.add(this.mesh);
  }

  /** Once per picture; `eyes` in the headset's own space. */
  update(seconds: Float64Array, shown: boolean, eyes: Vector3): void {
    const { mesh, hand, opacity } = this;
    if (!mesh) return;
    const step = Math.min(1, FADE_PER_SECOND * seconds[0]!);
    let brightest = 0;
    for (let i = 0; i < this.tips.length; i++) {
      const goal = shown && !this.lessons.learnt(this.tips[i]!.lesson) ? 1 : 0;
      const before = opacity[i]!;
      const now = goal > before ? Math.min(goal, before + step) : Math.max(goal, before - step);
      brightest = Math.max(brightest, now);
      if (now === before) continue;
      opacity[i] = now;
      this.fade(i);
    }
    mesh.visible = hand.grip.visible && brightest > 0.01;
    if (mesh.visible) faceEyes(mesh, hand.grip.position, eyes, this.facing);
  }

  private fade(line: number): void {
    const colors = this.mesh!.geometry.getAttribute('color');
    for (let k = 0; k < VERTICES; k++) {
      colors.array[4 * (VERTICES * line + k) + 3] = this.opacity[line]!;
    }
    colors.needsUpdate = true;
  }

  /** Legible hints, for tests. */
  get shown(): string[] {
    if (!this.mesh?.visible) return [];
    return this.tips.flatMap(({ text }, i) => (this.opacity[i]! > 0.01 ? text : []));
  }

  clear(): void {
    const { mesh } = this;
    this.mesh = null;
    this.tips = [];
    if (!mesh) return;
    mesh.removeFromParent();
    mesh.geometry.dispose();
    mesh.material.map!.dispose();
    mesh.material.dispose();
  }
}

/** Lines one below the other, to the right of the hand (`side` 1) or to its left (−1). */
function plate(tips: readonly Tip[], side: number): Mesh<BufferGeometry, MeshBasicMaterial> {
  const pen = document.createElement('canvas').getContext('2d')!;
  const { canvas } = pen;
  const font = `600 ${PIXELS}px ${FONT}`;
  pen.font = font;
  const widths = tips.map(({ text }) => pen.measureText(text).width + 2 * PAD * PIXELS);
  canvas.width = Math.ceil(Math.max(1, ...widths));
  canvas.height = Math.ceil(PITCH * PIXELS * Math.max(1, tips.length));
  pen.font = font;
  pen.textBaseline = 'middle';
  const lines = tips.map(({ text }, i) => {
    const top = i * PITCH * PIXELS;
    pen.fillStyle = INK.back;
    pen.beginPath();
    pen.roundRect(0, top, widths[i]!, HEIGHT * PIXELS, 0.4 * PIXELS);
    pen.fill();
    pen.fillStyle = INK.text;
    pen.fillText(text, PAD * PIXELS, top + (HEIGHT / 2 + 0.04) * PIXELS);
    return line(i, tips.length, widths[i]!, canvas, side);
  });
  const geometry = mergeGeometries(lines);
  for (const part of lines) part.dispose();
  const map = new CanvasTexture(canvas);
  map.colorSpace = SRGBColorSpace;
  const material = new MeshBasicMaterial({
    map, vertexColors: true, transparent: true, depthTest: false, depthWrite: false, toneMapped: false,
  }); // prettier-ignore
  const mesh = new Mesh(geometry, material);
  mesh.renderOrder = 115;
  mesh.frustumCulled = false;
  return mesh;
}

/** A quad for one line, and where it is on the canvas. */
function line(
  number: number,
  lines: number,
  width: number,
  canvas: HTMLCanvasElement,
  side: number,
): BufferGeometry {
  const metres = SIZES.tips.em / PIXELS;
  const [w, h] = [width * metres, HEIGHT * SIZES.tips.em];
  const y = ((lines - 1) / 2 - number) * PITCH * SIZES.tips.em;
  const geometry = tint(new PlaneGeometry(w, h), 0xffffff).translate(side * (BESIDE + w / 2), y, 0);
  const right = width / canvas.width;
  const [top, bottom] = [number * PITCH, number * PITCH + HEIGHT].map(
    (ems) => 1 - (ems * PIXELS) / canvas.height,
  ) as [number, number];
  const places = Float32Array.of(0, top, right, top, 0, bottom, right, bottom);
  geometry.setAttribute('uv', new BufferAttribute(places, 2));
  return geometry;
}
