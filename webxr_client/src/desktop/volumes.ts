/** Boxes under the mouse, the box tool's and the clip box: their handles are shown, found and dragged. */
import type { Ray, Vector3 } from 'three';
import { clip } from '../clip';
import type { Viewer } from '../cloud/viewer';
import { boxDraft } from '../tools/box-draft';
import { brushColor } from '../tools/brush';
import { dragged, placeOf, type Handle, type Volume } from '../volume/volume';
import { VolumeView } from '../volume/view';
import type { Aim } from './aim';

/** A handle is met so near to its middle, pixels. */
const NEAR = 11;
const CLIP_COLOR = '#ffc857';

const FACES: readonly Handle[] = ([0, 1, 2] as const).flatMap((axis) =>
  ([-1, 1] as const).map((side): Handle => ({ axis, side })),
);
const ALL: readonly Handle[] = [...FACES, 'move', 'turn'];

interface Edited {
  readonly volume: Volume;
  readonly handles: readonly Handle[];
  readonly color: string;
  readonly write: (volume: Volume) => void;
}

/** Return the boxes that can be changed now, the one on top first. */
function edited(): Edited[] {
  const found: Edited[] = [];
  const draft = boxDraft.peek();
  if (draft) {
    const write = (volume: Volume): void => void (boxDraft.value = volume);
    found.push({ volume: draft, handles: ALL, color: brushColor(), write });
  }
  const box = clip.peek();
  if (box) {
    const { slab } = box;
    const handles =
      slab === null ? ALL : FACES.filter((face) => typeof face === 'object' && face.axis === slab);
    const write = (volume: Volume): void => void (clip.value = { ...box, volume });
    found.push({ volume: box.volume, handles, color: CLIP_COLOR, write });
  }
  return found;
}

interface Grip {
  readonly edited: Edited;
  readonly handle: Handle;
  readonly from: Ray;
}

export class VolumeHandles {
  private readonly views: readonly VolumeView[];
  private grip: Grip | null = null;

  constructor(
    private readonly viewer: Viewer,
    private readonly aim: Aim,
  ) {
    this.views = [new VolumeView(viewer.world), new VolumeView(viewer.world)];
  }

  /** Before each picture. */
  update(): void {
    const now = edited();
    this.views.forEach((view, i) => {
      const one = now[i];
      if (one) view.show(one.volume, one.handles, one.color, this.viewer.renderer.getPixelRatio());
      else view.hide();
    });
  }

  /** Return the handle under the cursor, or null. */
  under(): { readonly edited: Edited; readonly handle: Handle } | null {
    let best = NEAR;
    let found: { edited: Edited; handle: Handle } | null = null;
    for (const one of edited()) {
      for (const handle of one.handles) {
        const away = this.pixelsTo(placeOf(one.volume, handle));
        if (away < best) {
          best = away;
          found = { edited: one, handle };
        }
      }
    }
    return found;
  }

  private pixelsTo(place: Vector3): number {
    const { camera, canvas } = this.viewer;
    const { x, y, z } = place.project(camera);
    if (z > 1) return Infinity;
    const [u, v] = [((x + 1) / 2) * canvas.clientWidth, ((1 - y) / 2) * canvas.clientHeight];
    return Math.hypot(u - this.aim.x, v - this.aim.y);
  }

  /** Take hold of the handle under the cursor; false where there is none. */
  grab(): boolean {
    const found = this.under();
    this.grip = found && { ...found, from: this.aim.roomRay() };
    return found !== null;
  }

  drag(): void {
    if (!this.grip) return;
    const { edited: one, handle, from } = this.grip;
    one.write(dragged(one.volume, handle, from, this.aim.roomRay()));
  }

  release(): void {
    this.grip = null;
  }
}
