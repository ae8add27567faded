/** Preview of the hand's selection, requested from the server before the trigger is pressed. */
import type { PointerSample } from '../../store/types';
import type { Engine } from '../../engine/engine';
import { state } from '../../store/state';
import type { Way } from '../../tools/ways';
import { watch } from '../../store/watch';

/** So often a question may be asked, milliseconds. */
const EVERY_MS = 60;
/** Bounds of a movement or turn that counts as still: metres, and parts of the unit direction. */
const STILL = 0.002;

export class PreviewRequests {
  private last = 0;
  private shownWay: Way | null = null;
  private readonly lastAim = new Float64Array(6).fill(NaN);
  private readonly unsubscribe: () => void;

  constructor(private readonly engine: Engine) {
    // A change of these ends the preview, so that a hand at rest must request a new one.
    const { tool, brush, activeLabel, palette, frame } = state;
    this.unsubscribe = watch([tool, brush, activeLabel, palette, frame], () =>
      this.lastAim.fill(NaN),
    );
  }

  /** Once per frame while the trigger is up; `sample` may be used again. */
  update(way: Way, sample: PointerSample, now: number): void {
    if (way.preview !== 'asked') {
      this.leave();
      return;
    }
    if (this.shownWay !== way) this.leave();
    if (now - this.last < EVERY_MS || !this.moved(sample)) return;
    this.last = now;
    this.shownWay = way;
    this.note(sample);
    const { objects, regions } = this.engine;
    if (way.samples === 'clicks') objects.hover(sample);
    else regions.hover(structuredClone(sample));
  }

  /** The hand is gone, or does something else. */
  leave(): void {
    if (!this.shownWay) return;
    this.shownWay = null;
    this.lastAim.fill(NaN);
    this.engine.objects.leave();
    this.engine.regions.leave();
  }

  dispose(): void {
    this.leave();
    this.unsubscribe();
  }

  private moved({ origin, direction }: PointerSample): boolean {
    for (let k = 0; k < 3; k++) {
      const still = Math.abs(origin[k]! - this.lastAim[k]!) < STILL;
      if (!still || !(Math.abs(direction[k]! - this.lastAim[3 + k]!) < STILL)) return true;
    }
    return false;
  }

  private note({ origin, direction }: PointerSample): void {
    for (let k = 0; k < 3; k++) {
      this.lastAim[k] = origin[k]!;
      this.lastAim[3 + k] = direction[k]!;
    }
  }
}
