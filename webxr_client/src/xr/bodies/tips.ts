/** Hints beside the controller for each button, until it has been used a few times. */
import { free } from '../../common/free';
import { BufferAttribute, CanvasTexture, Mesh, MeshBasicMaterial, PlaneGeometry, SRGBColorSpace, Vector3, type BufferGeometry } from 'three'; // prettier-ignore
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import { faceEyes } from '../drawing/facing';
import { tipsFor, type Lessons, type Part, type Tip } from '../input/lessons';
import type { Pointer } from '../input/pointer';
import type { Rig } from '../moving/rig';
import { SIZES } from '../drawing/sizes';
import { tint } from '../drawing/tint';
import { FONT, INK } from '../drawing/ui';

const FADE_PER_SECOND = 2;
const PIXELS = 48;
/** Ems: from one line to the next, a line's own height, and the room beside its text. */
const [PITCH, HEIGHT, PAD] = [1.95, 1.75, 0.6];
/** Metres from the middle of the hand to the words. */
const BESIDE = 0.035;
const VERTICES = 4;
/** Metres outside the picture at which a hand has no words. */
const ASTRAY = 0.25;
/** Moves that bring words inside, each by a share of what they lack: moved words are turned as well. */
const [PASSES, GAIN] = [6, 0.5];

/** All words of a hand on one plate: each line fades by its own vertices' opacity. */
export class Tips {
  private tips: readonly Tip[] = [];
  private opacity = new Float64Array(0);
  private mesh: Mesh<BufferGeometry, MeshBasicMaterial> | null = null;
  private readonly facing = { right: 0, up: 0, away: SIZES.tips.away };
  private readonly shift = new Float64Array(2);
  private readonly corner = new Vector3();

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

  /** Once per picture. */
  update(seconds: Float64Array, shown: boolean, rig: Rig): void {
    const { mesh, hand, opacity } = this;
    if (!mesh) return;
    const near = shown && this.nearPicture(rig);
    const step = Math.min(1, FADE_PER_SECOND * seconds[0]!);
    let brightest = 0;
    for (let i = 0; i < this.tips.length; i++) {
      const goal = near && !this.lessons.learnt(this.tips[i]!.lesson) ? 1 : 0;
      const before = opacity[i]!;
      const now = goal > before ? Math.min(goal, before + step) : Math.max(goal, before - step);
      brightest = Math.max(brightest, now);
      if (now === before) continue;
      opacity[i] = now;
      this.fade(i);
    }
    mesh.visible = hand.grip.visible && brightest > 0.01;
    if (mesh.visible) this.keepInside(mesh, rig);
  }

  /** Whether the hand is in the picture, or near to it. */
  private nearPicture({ inHead, sight }: Rig): boolean {
    const { corner, shift } = this;
    shift.fill(0);
    corner.copy(this.hand.grip.position).applyMatrix4(inHead);
    sight.lacks(corner, shift);
    return corner.z < 0 && Math.hypot(shift[0]!, shift[1]!) < ASTRAY;
  }

  /** Place the words beside the hand, moved as far as keeps them in both eyes' pictures. */
  private keepInside(mesh: Mesh, { headInRig, inHead, sight }: Rig): void {
    const { facing, shift, corner } = this;
    const { min, max } = mesh.geometry.boundingBox!;
    facing.right = facing.up = 0;
    for (let pass = 0; pass <= PASSES; pass++) {
      faceEyes(mesh, this.hand.grip.position, headInRig, facing);
      shift.fill(0);
      for (let k = 0; k < VERTICES; k++) {
        corner.set(k & 1 ? max.x : min.x, k & 2 ? max.y : min.y, 0);
        sight.lacks(corner.applyMatrix4(mesh.matrix).applyMatrix4(inHead), shift);
      }
      const e = mesh.matrix.elements;
      const grown = Math.sqrt(e[0] * e[0] + e[2] * e[2]);
      facing.right += (GAIN * shift[0]!) / grown;
      facing.up += (GAIN * shift[1]!) / grown;
    }
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
    mesh.material.map!.dispose();
    free(mesh);
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
  geometry.computeBoundingBox();
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
