/** Places of the recording: flying to one, marking it, pointing at one. */
import { Vector3 } from 'three';
import { Aim } from '../view/aim';
import type { Engine } from '../engine/engine';
import { state } from '../store/state';
import { follow } from '../store/watch';
import type { Place } from './model';
import { looking, marked, markedFrom, pointing, RISE } from './places';

/** Distance to come within, as a share of the recording's diagonal, and in metres. */
const NEAR_SHARE = 0.2;
const [NEAREST, FARTHEST] = [0.8, 10];
/** Least downward part of the view's direction, so that objects do not hide the place. */
const LEAST_DOWN = 0.25;
/** Metres within which a click meets a point. */
const REACH = 0.1;
/** Metres within which the middle of the picture meets a point. */
const MIDDLE_REACH = 1;

export class Flight {
  private readonly mark: HTMLElement;
  private readonly at = new Vector3();
  private readonly aim: Aim;

  constructor(private readonly engine: Engine) {
    const { canvas } = engine.viewer;
    this.aim = new Aim(engine.viewer, () => engine.playback.frame);
    this.mark = document.createElement('div');
    this.mark.className = 'work-mark';
    this.mark.hidden = true;
    canvas.after(this.mark);
    looking.at = () => this.middle();
    engine.viewer.ticks.add(() => this.draw());
    follow(() => {
      const place = marked.value;
      if (place) this.fly(place);
      engine.viewer.invalidate();
    });
    follow(() => canvas.classList.toggle('pointing', pointing.value !== null));
    canvas.addEventListener('pointerdown', (event) => this.point(event), { capture: true });
  }

  /** To room coordinates. */
  private room([x, y, z]: Place): Vector3 {
    const [a, b, c] = state.sequence.peek()?.shift ?? [0, 0, 0];
    return this.at.set(x - a, y - b, z - c).applyMatrix4(this.engine.viewer.room.matrixWorld);
  }

  private fly(place: Place): void {
    const info = state.sequence.peek();
    if (!info) return;
    const target = this.room(place).clone();
    const { camera } = this.engine.viewer;
    const back = camera.position.clone().sub(target);
    const distance = back.length();
    if (distance < 1e-3) back.set(0, 0.5, 1);
    back.normalize();
    const from = markedFrom.peek();
    back.y = Math.max(back.y, from > 0 ? RISE : LEAST_DOWN);
    const diagonal = new Vector3(...info.hi).distanceTo(new Vector3(...info.lo));
    const near = Math.min(FARTHEST, Math.max(NEAREST, NEAR_SHARE * diagonal));
    const far = Math.min(near, Math.max(distance, NEAREST));
    back.normalize().multiplyScalar(from || far);
    this.engine.camera.lookAt(target.clone().add(back), target);
  }

  /** While a place is chosen, a click gives it and starts no stroke. */
  private point(event: PointerEvent): void {
    const take = pointing.peek();
    if (!take || event.button !== 0) return;
    event.stopImmediatePropagation();
    event.preventDefault();
    this.aim.place(event);
    const place = this.met(REACH);
    if (!place) return;
    pointing.value = null;
    take(place);
  }

  /** The point that is aimed at, within metres of the ray. */
  private met(reach: number): Place | null {
    const hit = this.aim.hit(reach);
    if (!hit) return null;
    const [a, b, c] = state.sequence.peek()?.shift ?? [0, 0, 0];
    const [x, y, z] = hit.position;
    return [x + a, y + b, z + c];
  }

  private middle(): Place | null {
    this.aim.placeInMiddle();
    return this.met(REACH) ?? this.met(MIDDLE_REACH);
  }

  private draw(): void {
    const place = marked.peek();
    const { camera, canvas } = this.engine.viewer;
    const projected = place && this.room(place).project(camera);
    const shown = projected !== null && projected.z < 1 && state.xr.peek().session !== 'running';
    this.mark.hidden = !shown;
    if (!shown) return;
    const x = ((projected.x + 1) / 2) * canvas.clientWidth;
    const y = ((1 - projected.y) / 2) * canvas.clientHeight;
    this.mark.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
  }
}
