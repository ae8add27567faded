/** Completes a stroke to the object that it lies on: by its offer, or while the trigger is held. */
import { actions } from '../../store/actions';
import { state } from '../../store/state';
import type { PointerSample } from '../../store/types';
import { peek, watch } from '../../store/watch';
import type { ObjectTool } from '../../tools/object';
import { Path } from '../../tools/path';
import { roomWay } from '../../tools/ways';

/** An offer ends by itself after this, milliseconds. */
const OFFER_MS = 4000;
/** An object that was shown for less, milliseconds, is not taken by letting go. */
const SEEN_MS = 300;

export class Completion {
  private readonly path = new Path();
  /** The stroke with an object to choose while its trigger is held, or empty. */
  private stroke = '';
  /** Milliseconds for which an object has been shown, and the time of the last picture. */
  private readonly age = new Float64Array(1);
  private readonly last = new Float64Array(1);
  private readonly unwatch: () => void;

  constructor(private readonly objects: Pick<ObjectTool, 'complete' | 'end' | 'waits'>) {
    this.unwatch = watch([state.playing], () => {
      if (this.waits) this.objects.end();
    });
  }

  /** Start a stroke, and end the suggestions for the previous one. */
  begin(): void {
    this.objects.end();
    this.path.clear();
    this.stroke = '';
  }

  /** `back`: metres that the sample's ray begins earlier. */
  add(sample: PointerSample, back: number): void {
    this.path.add(sample, back);
  }

  /** A stroke has ended: offer its object. */
  offer(stroke: string): void {
    this.age[0] = 0;
    this.objects.complete(this.path.samples(), stroke);
  }

  /** Choose the object of a stroke that has ended although its trigger is held. */
  hold(stroke: string): void {
    this.stroke = stroke;
    this.offer(stroke);
  }

  get held(): boolean {
    return this.stroke !== '';
  }

  /** A push up (1) or down (−1) while the trigger is held; below the smallest level the stroke is left as it is. */
  step(steps: number): void {
    const view = peek(state.object);
    if (view?.completes !== true) {
      if (steps > 0 && !this.objects.waits) this.offer(this.stroke);
    } else if (steps < 0 && view.level === 0) this.objects.end();
    else actions.tools.stepObject(steps);
  }

  /** Accept the shown object on release of the trigger. `given`: unintended release, accept none. */
  release(given: boolean): void {
    this.stroke = '';
    if (given) this.objects.end();
    else if (this.age[0]! >= SEEN_MS && actions.tools.completeObject()) this.objects.end();
  }

  /** Once per picture; `paused`: a panel is open, where the offer may be taken. */
  update(paused: boolean, now: number): void {
    const { age, last } = this;
    age[0] = this.waits ? age[0]! + now - last[0]! : 0;
    last[0] = now;
    if (this.held || age[0] < OFFER_MS) return;
    if (paused) age[0] = 0;
    else this.objects.end();
  }

  /** Whether an object is offered for a stroke, or was just taken for it. */
  private get waits(): boolean {
    const view = peek(state.object);
    return view !== null && (view.completes || roomWay().samples !== 'clicks');
  }

  dispose(): void {
    this.unwatch();
    this.objects.end();
  }
}
