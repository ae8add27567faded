/** Brings a frame's pictures to the strip, and what is pointed at there to the cloud. */
import type { Vec } from '../cloud/pick';
import { Vector3 } from 'three';
import type { Engine } from '../engine/engine';
import { api } from '../net/rest';
import { state } from '../state';
import { watch } from '../watch';
import type { CameraPicture, Lens } from './lens';
import { PlaceMarker } from './marker';
import { pictures, pointed, projectedFrame, stripOpen, type Pictures } from './state';

/** Milliseconds between two looks at what is on screen: pictures need not follow every stroke's dab. */
const LOOK_MS = 150;
/** From the camera's side, this part of its way to the place remains, within these metres. */
const [PART, NEAR, FAR] = [0.4, 1.5, 12];

export class CameraStrip {
  private readonly marker: PlaceMarker;
  private readonly known = new Map<number, readonly CameraPicture[]>();
  private looked = 0;
  private asked = 0;

  constructor(private readonly engine: Engine) {
    this.marker = new PlaceMarker(engine.viewer.room);
    watch([state.sequence], () => {
      this.known.clear();
      pictures.value = projectedFrame.value = pointed.value = null;
    });
    watch([state.shown], () => void this.look());
    watch([pointed, state.frame], () => {
      const at = pointed.peek();
      this.marker.show(at?.by === 'picture' ? at.place : null);
      engine.viewer.invalidate();
    });
    engine.viewer.ticks.add((now) => this.update(now));
  }

  /** The pictures of the frame on screen. */
  private async look(): Promise<void> {
    const info = state.sequence.peek();
    const { frame } = state.shown.peek();
    if (!info || frame < 0) return;
    const before = pictures.peek();
    if (before?.sequence === info.id && before.frame === frame) return;
    const asked = ++this.asked;
    let cameras = this.known.get(frame);
    if (!cameras) {
      try {
        cameras = await api<CameraPicture[]>('GET', `sequences/${info.id}/frames/${frame}/cameras`);
      } catch {
        return; // the banner says that the server is away; the next frame asks again
      }
      if (state.sequence.peek()?.identity !== info.identity) return;
      this.known.set(frame, cameras);
    }
    if (asked === this.asked) pictures.value = { sequence: info.id, frame, cameras };
  }

  /** Before each picture: whether points or labels are others. */
  private update(now: number): void {
    const { frame } = this.engine.playback;
    if (!stripOpen.peek() || !frame || !has(pictures.peek()) || now - this.looked < LOOK_MS) return;
    this.looked = now;
    const before = projectedFrame.peek();
    if (before?.frame === frame && before.version === frame.version) return;
    projectedFrame.value = { frame, version: frame.version };
  }

  /** Look at a place (local) from a camera's side, with the brush on it. */
  aim(place: Vec, lens: Lens): void {
    const { room } = this.engine.viewer;
    const target = new Vector3(...place);
    const back = new Vector3(...lens.eye).sub(target);
    const far = Math.min(FAR, Math.max(NEAR, PART * back.length()), back.length());
    const eye = target.clone().addScaledVector(back.normalize(), far);
    this.engine.camera.lookAt(eye.applyMatrix4(room.matrix), target.applyMatrix4(room.matrix));
    this.engine.aimAtMiddle();
  }
}

function has(found: Pictures | null): boolean {
  return found !== null && found.cameras.length > 0;
}

let strip: CameraStrip | null = null;

export function installCameras(engine: Engine): void {
  strip = new CameraStrip(engine);
}

/** Look at a place from a camera's side, with the brush on it. */
export function aimAt(place: Vec, lens: Lens): void {
  strip?.aim(place, lens);
}
