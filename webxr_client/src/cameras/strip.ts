/** Loads the pictures for the strip, and marks the place in the cloud under a picture's pointer. */
import type { Vec } from '../store/types';
import { CanvasTexture, type Group, Sprite, SpriteMaterial, Vector3 } from 'three';
import { PREVIEW } from '../cloud/picture/palette';
import { actions } from '../store/actions';
import type { Engine } from '../engine/engine';
import { api } from '../net/rest';
import type { SequenceInfo } from '../protocol/messages';
import type { Camera } from '../protocol/values';
import { state } from '../store/state';
import { watch } from '../store/watch';
import { depthCamera } from './depth-picture';
import type { Lens } from './lens';
import { labelChanges, pictures, pointed, projectedFrame, stripOpen } from './state';

/** Least time between two updates, milliseconds: pictures do not follow every dab of a stroke. */
const LOOK_MS = 150;
/** Overlay that lights up a label's points, and its duration, milliseconds. */
const [LIT, LIT_MS] = ['lit', 1500];
/** Distance of the view from a place, as a share of the camera's, and its bounds, metres. */
const [PART, NEAR, FAR] = [0.4, 1.5, 12];

class CameraStrip {
  private readonly marker: PlaceMarker;
  private readonly known = new Map<number, readonly Camera[]>();
  private looked = 0;
  private newestRequest = 0;
  private unlight = (): void => undefined;

  constructor(private readonly engine: Engine) {
    this.marker = new PlaceMarker(engine.viewer.room);
    watch([state.sequence], () => {
      this.known.clear();
      pictures.value = projectedFrame.value = pointed.value = null;
    });
    watch([state.shown], () => void this.look());
    watch([state.counts, state.palette], () => (labelChanges.value += 1));
    watch([pointed, state.frame], () => {
      const at = pointed.peek();
      this.marker.show(at?.by === 'picture' ? at.place : null);
      engine.viewer.invalidate();
    });
    engine.viewer.ticks.add((now) => this.update(now));
  }

  /** Load the pictures of the frame on screen. */
  private async look(): Promise<void> {
    const info = state.sequence.peek();
    const { frame } = state.shown.peek();
    if (!info || frame < 0) return;
    if (arePicturesOf(info.id, frame)) return;
    const request = ++this.newestRequest;
    const cameras = this.known.get(frame) ?? (await this.load(info, frame));
    if (!cameras || request !== this.newestRequest) return;
    const images = this.engine.playback.frame?.images ?? [];
    const own = cameras.length === 0 && images.length > 0 ? images.map((image) => depthCamera(image, info)) : null; // prettier-ignore
    pictures.value = { sequence: info.id, frame, cameras: own ?? cameras, drawn: own !== null };
  }

  /** Return the cameras of a frame; null if the server is unavailable or the recording changed. */
  private async load(info: SequenceInfo, frame: number): Promise<Camera[] | null> {
    try {
      const cameras = await api<Camera[]>('GET', `sequences/${info.id}/frames/${frame}/cameras`);
      if (state.sequence.peek()?.identity !== info.identity) return null;
      this.known.set(frame, cameras);
      return cameras;
    } catch {
      return null; // the banner shows that the server is unavailable; the next frame asks again
    }
  }

  /** Before each drawn picture: show changed points and labels in the pictures. */
  private update(now: number): void {
    const { frame } = this.engine.playback;
    if (stripOpen.peek() === false || !frame || !pictures.peek()?.cameras.length) return;
    if (now - this.looked < LOOK_MS) return;
    this.looked = now;
    const before = projectedFrame.peek();
    if (before?.frame === frame && before.version === frame.version) return;
    projectedFrame.value = { frame, version: frame.version };
  }

  /** Light up the points of a label in the cloud for a moment. */
  light(label: number): void {
    const { viewer, playback } = this.engine;
    const { frame } = playback;
    this.unlight();
    if (!frame) return;
    frame.setOverlay(LIT, { indices: frame.pointsOf(label), values: Uint16Array.of(PREVIEW) });
    viewer.setOutlined(LIT, true);
    const timer = setTimeout(() => this.unlight(), LIT_MS);
    this.unlight = () => {
      clearTimeout(timer);
      frame.dropOverlay(LIT);
      viewer.setOutlined(LIT, false);
      this.unlight = () => undefined;
    };
  }

  /** Turn the view to a place (local metres) from a camera's side, with the brush on the place. */
  aim(place: Vec, lens: Lens): void {
    const { room } = this.engine.viewer;
    const target = new Vector3(...place);
    const back = new Vector3(...lens.eye).sub(target);
    const far = Math.min(FAR, Math.max(NEAR, PART * back.length()), back.length());
    const eye = target.clone().addScaledVector(back.normalize(), far);
    this.engine.camera.lookAt(eye.applyMatrix4(room.matrix), target.applyMatrix4(room.matrix));
    actions.tools.aimAtMiddle();
  }
}

function arePicturesOf(sequence: string, frame: number): boolean {
  const shown = pictures.peek();
  return shown?.sequence === sequence && shown.frame === frame;
}

let strip: CameraStrip | null = null;

export function installCameras(engine: Engine): void {
  strip = new CameraStrip(engine);
}

/** Turn the view to a place (local metres) from a camera's side, with the brush on the place. */
export function aimAt(place: Vec, lens: Lens): void {
  strip?.aim(place, lens);
}

/** Light up the points of a label in the cloud for a moment. */
export function lightUp(label: number): void {
  strip?.light(label);
}

/** Pixels of the cross's texture, and its height as a share of the view's. */
const [SIZE, SHARE] = [64, 0.045];
/** A circle and four arms, pixels of the texture. */
const CROSS = 'M50 32a18 18 0 1 1-36 0a18 18 0 1 1 36 0M42 32h18M22 32h-18M32 42v18M32 22v-18';

/** A cross in the cloud at the place under the pointer in a picture. */
class PlaceMarker {
  private readonly sprite: Sprite;

  constructor(private readonly room: Group) {
    const map = new CanvasTexture(cross());
    const material = new SpriteMaterial({
      map,
      depthTest: false,
      sizeAttenuation: false,
      transparent: true,
    });
    this.sprite = new Sprite(material);
    this.sprite.scale.setScalar(SHARE);
    this.sprite.renderOrder = 90;
    this.sprite.visible = false;
    room.parent?.add(this.sprite);
  }

  /** Show the cross at a place, local metres; null: hide it. */
  show(place: Vec | null): void {
    this.sprite.visible = place !== null;
    if (place) this.sprite.position.set(...place).applyMatrix4(this.room.matrix);
  }
}

function cross(): HTMLCanvasElement {
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = SIZE;
  const pen = canvas.getContext('2d')!;
  const path = new Path2D(CROSS);
  Object.assign(pen, { lineWidth: 7, strokeStyle: '#0b0e12' }).stroke(path);
  Object.assign(pen, { lineWidth: 3, strokeStyle: '#ffffff' }).stroke(path);
  return canvas;
}
