/** The way of the active label's object through the frames near the playhead. */
import { BufferGeometry, DynamicDrawUsage, Float32BufferAttribute, Line, LineBasicMaterial, Points, PointsMaterial, Vector3, type Object3D } from 'three'; // prettier-ignore
import type { CloudFrame } from '../cloud/frame';
import type { Engine } from '../engine/engine';
import { activeLabel, state } from '../state';
import { xrSettings } from './settings';

/** Frames before and after the playhead. */
const REACH = 45;
const PLACES = 2 * REACH + 1;
/** Metres. */
const DOT = 0.014;

/** The middle of a label's points in a frame, local coordinates; false when it has none here. */
export function middleOf(frame: CloudFrame, label: number, out: Vector3): boolean {
  let count = 0;
  out.set(0, 0, 0);
  for (const { labels, words, origin, scale } of frame.pieces) {
    if (!labels) continue;
    for (let i = 0, w = 0; i < labels.length; i++, w += 6) {
      if (labels[i] !== label) continue;
      count += 1;
      out.x += origin[0] + words[w]! * scale[0];
      out.y += origin[1] + words[w + 1]! * scale[1];
      out.z += origin[2] + words[w + 2]! * scale[2];
    }
  }
  if (count === 0) return false;
  out.divideScalar(count);
  return true;
}

export class Trail {
  private readonly line: Line<BufferGeometry, LineBasicMaterial>;
  private readonly dots: Points<BufferGeometry, PointsMaterial>;
  private readonly middle = new Vector3();
  /** What each place of the line was computed from: a frame and its versions. */
  private readonly known = new Float64Array(PLACES).fill(-1);
  private readonly found = new Float32Array(3 * PLACES).fill(NaN);
  private label = -1;
  private next = 0;

  constructor(
    private readonly engine: Engine,
    room: Object3D,
  ) {
    const geometry = new BufferGeometry();
    const places = new Float32BufferAttribute(new Float32Array(3 * PLACES), 3);
    geometry.setAttribute('position', places.setUsage(DynamicDrawUsage));
    const material = new LineBasicMaterial({ transparent: true, opacity: 0.85, depthTest: false });
    this.line = new Line(geometry, material);
    this.line.frustumCulled = false;
    this.line.renderOrder = 60;
    // A dot for each frame: a line alone is a hair in a headset.
    const dots = new PointsMaterial({ size: DOT, transparent: true, depthTest: false });
    this.dots = new Points(geometry, dots);
    this.dots.frustumCulled = false;
    this.dots.renderOrder = 61;
    this.line.add(this.dots);
    room.add(this.line);
  }

  /** Once per picture: looks at one frame, so that it costs little. */
  update(): void {
    const active = activeLabel.peek();
    const info = state.sequence.peek();
    this.line.visible = xrSettings.peek().trail && active !== null && info !== null && !info.large;
    if (!active || !info || !this.line.visible) return;
    if (active.id !== this.label) {
      this.label = active.id;
      this.known.fill(-1);
    }
    this.line.material.color.set(active.color);
    this.dots.material.color.set(active.color);
    this.next = (this.next + 1) % PLACES;
    this.look(this.next);
    this.draw(info.frames);
  }

  /** Frames go round in the table: frame i is at i modulo its length. */
  private look(slot: number): void {
    const { found, known, middle } = this;
    const head = state.frame.peek();
    const first = head - REACH;
    const index = first + ((((slot - first) % PLACES) + PLACES) % PLACES);
    const frame = index >= 0 ? this.engine.playback.store.get(index) : undefined;
    const key = frame ? index * 1e7 + frame.labelsVersion * 1e3 + frame.pointsVersion : -1;
    if (key === known[slot]) return;
    known[slot] = key;
    const here = frame !== undefined && middleOf(frame, this.label, middle);
    found[3 * slot] = here ? middle.x : NaN;
    found[3 * slot + 1] = middle.y;
    found[3 * slot + 2] = middle.z;
  }

  private draw(frames: number): void {
    const places = this.line.geometry.getAttribute('position');
    const head = state.frame.peek();
    let count = 0;
    for (
      let index = Math.max(0, head - REACH);
      index <= Math.min(frames - 1, head + REACH);
      index++
    ) {
      const slot = index % PLACES;
      const x = this.found[3 * slot]!;
      if (Number.isNaN(x) || Math.floor(this.known[slot]! / 1e7) !== index) continue;
      places.setXYZ(count, x, this.found[3 * slot + 1]!, this.found[3 * slot + 2]!);
      count += 1;
    }
    places.needsUpdate = true;
    this.line.geometry.setDrawRange(0, count);
  }

  dispose(): void {
    this.line.removeFromParent();
    this.line.geometry.dispose();
    this.line.material.dispose();
    this.dots.material.dispose();
  }
}
