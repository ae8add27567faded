/** Going to an object, and following it through time. */
import { signal } from '@preact/signals';
import { Vector3 } from 'three';
import type { CloudFrame } from '../cloud/points/frame';
import type { Viewer } from '../cloud/picture/viewer';
import { placeOfLabel, type LabelPlace } from '../cloud/points/whereabouts';
import type { DeskCamera } from './camera';
import { hasPoints } from '../store/cells';
import { notify, state, type TimelineRow } from '../store/state';

/** The camera goes along with the active label. */
export const followsObject = signal(false);

/** An object takes about this part of the picture's height. */
const SHARE = 0.25;
/** The least radius of a target, metres. */
const SMALLEST = 0.05;

export interface LabelNavigationDeps {
  readonly viewer: Pick<Viewer, 'room' | 'invalidate'>;
  readonly camera: DeskCamera;
  /** The frame on screen. */
  readonly frame: () => CloudFrame | null;
  readonly seek: (frame: number) => void;
}

export class LabelNavigation {
  /** A label to go to once the frame that it is in has come. */
  private wanted: { readonly label: number; readonly frame: number } | null = null;
  /** Place of the followed label when it was last seen. */
  private label = 0;
  private seen: CloudFrame | null = null;
  private readonly last = new Vector3();

  constructor(private readonly deps: LabelNavigationDeps) {}

  /** Fly to a label once `frame` is on screen, without it in this one, or the nearest that has it. */
  goTo(label: number, at?: number): void {
    this.wanted = at === undefined ? null : { label, frame: at };
    if (this.wanted) return;
    const entry = state.palette.peek().find(({ id }) => id === label);
    if (!entry) {
      notify('info', 'Choose a label first', 'The camera goes to the object of the label.');
      return;
    }
    const frame = this.deps.frame();
    const place = frame && placeOfLabel(frame, label);
    if (place) {
      this.fly(place);
      return;
    }
    const nearest = nearestWith(state.timeline.peek().rows.get(label), state.frame.peek());
    if (nearest === null || nearest === frame?.index) {
      notify('info', `“${entry.name}” has no points to go to`, 'Paint some points first.');
      return;
    }
    this.wanted = { label, frame: nearest };
    this.deps.seek(nearest);
    notify(
      'info',
      `“${entry.name}” is in frame ${nearest}`,
      'This is the nearest frame with the label.',
    );
  }

  /** Before each picture. */
  update(): void {
    const frame = this.deps.frame();
    if (!frame) return;
    if (this.wanted?.frame === frame.index && frame.loaded > 0) {
      const place = placeOfLabel(frame, this.wanted.label);
      // There is nothing to go to in frames in which it is lost.
      if (place || frame.complete) this.wanted = null;
      if (place) this.fly(place);
    } else if (this.wanted && this.wanted.frame !== state.frame.peek()) this.wanted = null;
    if (followsObject.peek()) this.follow(frame);
    else this.seen = null;
  }

  private follow(frame: CloudFrame): void {
    const label = state.activeLabel.peek();
    if (frame === this.seen && label === this.label) return;
    const place = placeOfLabel(frame, label);
    const other = this.seen === null || label !== this.label;
    this.seen = frame;
    this.label = label;
    if (!place) return;
    const { viewer, camera } = this.deps;
    const now = place.middle.applyMatrix4(viewer.room.matrixWorld);
    if (!other) camera.move(this.last.negate().add(now));
    else camera.aimAt(now);
    this.last.copy(now);
    viewer.invalidate();
  }

  private fly({ middle, radius }: LabelPlace): void {
    const { viewer, camera } = this.deps;
    camera.approach(middle.applyMatrix4(viewer.room.matrixWorld), Math.max(SMALLEST, radius) / SHARE); // prettier-ignore
    viewer.invalidate();
  }
}

/** The frame nearest to `from` with points of a label; null without any. */
export function nearestWith(row: TimelineRow | undefined, from: number): number | null {
  if (!row) return null;
  for (let distance = 0; distance < row.points.length; distance++) {
    for (const frame of [from - distance, from + distance]) if (hasPoints(row, frame)) return frame;
  }
  return null;
}
