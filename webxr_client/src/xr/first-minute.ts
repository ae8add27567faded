/** The first minute: a sequence of hints, each completed by performing its action. */
import type { Engine } from '../engine/engine';
import { notify, state, trackingJob } from '../store/state';
import { peek, watch } from '../store/watch';
import { change, xrSettings } from '../store/xr-settings';
import { completes, roomWay } from '../tools/ways';
import type { Cockpit } from './cockpit';
import type { Headset } from './headset';
import { possible, taught, type Lesson } from './input/lessons';
import { GuidePanel } from './panels/guide-panel';

interface Step {
  readonly lesson: Lesson;
  readonly title: string;
  readonly possible: () => boolean;
  /** The way to do it; `hint`: the control that does it, where one does. */
  readonly how: (hint: string | null) => string;
}

const paints = (): boolean => possible('paint');
const labels = (): number => peek(state.palette).length;
/** Whether this frame has something to track. */
const tracks = (): boolean =>
  [...peek(state.timeline).rows.values()].some(({ points }) => points[peek(state.frame)]! > 0);

const STEPS: readonly Step[] = [
  { lesson: 'paint', title: 'paint', possible: paints, how: (hint) =>
    labels() < 1 ? 'Palette, New: make a label' : hint ? `${hint}, with the ball in an object` : 'Look at an object and press' },
  { lesson: 'label', title: 'switch the label', possible: paints, how: (hint) =>
    labels() < 2 ? 'Palette, New: make a second label' : hint ?? 'Palette: choose another label' },
  { lesson: 'object', title: 'the whole object', possible: () => paints() && peek(state.brush).complete && completes(roomWay()), how: (hint) =>
    hint ? `${hint}, then let go` : 'Paint, then Palette, Tools: Complete' },
  { lesson: 'play', title: 'play', possible: () => possible('play'), how: (hint) => hint ?? 'Timeline: play' },
  { lesson: 'panel', title: 'track', possible: () => paints() && possible('play'), how: (hint) =>
    !tracks() ? 'Paint, or go to a painted frame' : hint ? `${hint}, then To end` : 'Timeline: To end' },
]; // prettier-ignore

/** One walk through the steps, from its beginning until it is finished, skipped or left. */
class Walk {
  private step = STEPS[0]!;
  private readonly stops: (() => void)[];

  constructor({ strokes }: Engine, cockpit: Cockpit) {
    const panel = new GuidePanel({
      title: () => `${STEPS.indexOf(this.step) + 1} of ${STEPS.length}: ${this.step.title}`,
      how: () => this.step.how(cockpit.pointers.hint(this.step.lesson)),
      next: () => this.go(STEPS.indexOf(this.step) + 1),
    });
    const { activeLabel, playing } = state;
    const label = activeLabel.peek();
    this.stops = [
      cockpit.hang(panel),
      strokes.results.add(({ changed }) => changed > 0 && this.complete('paint')),
      strokes.begins.add(({ brush }) => brush.shape === 'object' && this.complete('object')),
      watch([activeLabel], () => activeLabel.peek() !== label && this.complete('label')),
      watch([playing], () => playing.peek() && this.complete('play')),
      watch([trackingJob], () => trackingJob.peek() !== null && this.complete('panel')),
    ];
    this.go(0);
  } // prettier-ignore

  private complete(lesson: Lesson): void {
    if (this.step.lesson === lesson) this.go(STEPS.indexOf(this.step) + 1);
  }

  /** Go to the next step that is possible, from one on; after the last one it ends. */
  private go(from: number): void {
    const step = STEPS.find((each, i) => i >= from && each.possible());
    if (step) {
      this.step = step;
      taught.value = step.lesson;
      return;
    }
    notify('info', 'That was the first minute', 'Palette, Comfort shows it once more.');
    change({ guide: false });
  }

  stop(): void {
    taught.value = null;
    for (const stop of this.stops) stop();
  }
}

/** Lead through the first minute in each session, until it was finished or skipped in this browser. */
export function leadFirstMinute(engine: Engine, headset: Headset): void {
  let walk: Walk | null = null;
  watch([state.xr, xrSettings], () => {
    const { cockpit } = headset;
    const wanted = state.xr.peek().session === 'running' && peek(xrSettings).guide;
    if (wanted && cockpit && STEPS.some((step) => step.possible())) {
      walk ??= new Walk(engine, cockpit);
      return;
    }
    walk?.stop();
    walk = null;
  });
}
