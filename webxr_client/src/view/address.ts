/** Keeps the address true to the place, so that it can be sent and the page be loaded again. */
import { Vector3 } from 'three';
import type { DeskCamera } from './camera';
import { placeIn, withPlace, type View } from '../net/address';
import { state } from '../store/state';
import { follow } from '../store/watch';

/** Browsers take few changes of an address in a short time, milliseconds. */
const EVERY_MS = 500;

export class Address {
  private readonly wanted = placeIn(location.search);
  private view = this.wanted.view;
  private last = 0;
  private written = '';
  private readonly eye = new Vector3();

  constructor(private readonly camera: DeskCamera) {
    const { label } = this.wanted;
    const stop = follow(() => {
      const palette = state.palette.value;
      if (palette.length === 0) return;
      if (palette.some(({ id }) => id === label)) state.activeLabel.value = label;
      queueMicrotask(() => stop());
    });
  }

  /** A recording is on screen for the first time: take the view that the address names, once. */
  framed(): void {
    const { view } = this;
    this.view = null;
    if (!view) return;
    const [x, y, z, ...target] = view;
    this.camera.lookAt(new Vector3(x, y, z), new Vector3(...target), true);
  }

  /** Write changes to the address at intervals. */
  update(now: number): void {
    const sequence = state.sequence.peek();
    if (now - this.last < EVERY_MS || !sequence || state.playing.peek() || this.view) return;
    this.last = now;
    const frame = state.frame.peek();
    const place = { frame, label: state.activeLabel.peek(), view: this.viewNow() };
    const address = withPlace(location.href, place);
    if (address === this.written) return;
    this.written = address;
    history.replaceState(null, '', address);
  }

  private viewNow(): View {
    const { camera, pivot } = this.camera;
    const { x, y, z } = camera.position;
    const ahead = this.eye.set(0, 0, -1).applyQuaternion(camera.quaternion);
    const depth = Math.max(0.1, pivot.clone().sub(camera.position).dot(ahead));
    ahead.multiplyScalar(depth).add(camera.position);
    return [x, y, z, ahead.x, ahead.y, ahead.z];
  }
}
