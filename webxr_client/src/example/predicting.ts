/** Shows on the frame on screen what a classifier predicts of it, and paints answers to its doubts. */
import { ASKED, DOUBT, DOUBT_STEPS, PREDICTED } from '../cloud/picture/palette';
import type { CloudFrame } from '../cloud/points/frame';
import { lowerBound } from '../cloud/points/piece';
import { sureColour } from '../engine/colouring';
import type { Engine } from '../engine/engine';
import { ApiError } from '../net/rest';
import { actions } from '../store/actions';
import { notify, state } from '../store/state';
import { follow, watch } from '../store/watch';
import { lookedAt } from './looking';
import { coloursOf, countOf, idsOf, labelOf, type Prediction } from './model';
import {
  type Answer,
  answer,
  asking,
  classifier,
  exampleOpen,
  ignore,
  ignored,
  leaveQuestion,
  looking,
  nextDoubt,
  predict,
  predicted,
  question,
  showPlace,
  shows,
} from './store';

/** Edits and frames come one after the other: the server is asked once they rest, milliseconds. */
const REST_MS = 120;

export class Predicting {
  /** Predictions of the frames that are here. */
  private readonly said = new WeakMap<CloudFrame, Prediction>();
  private timer: ReturnType<typeof setTimeout> | undefined;
  private request: AbortController | null = null;
  /** Of large frames: the frame, classifier, labels and place that were asked about last. */
  private asked: readonly unknown[] = [];

  constructor(private readonly engine: Engine) {
    const { palette } = engine.viewer;
    looking.at = () => {
      const frame = engine.frame();
      return frame ? this.placeIn(frame) : undefined;
    };
    const steps = Array.from({ length: DOUBT_STEPS }, (_, k) => sureColour(k / (DOUBT_STEPS - 1)));
    palette.setPredicted(DOUBT, steps);
    follow(() => {
      const classes = classifier.value?.classes ?? [];
      palette.setPredicted(PREDICTED, coloursOf(classes, state.palette.value));
      engine.viewer.invalidate();
    });
    watch([exampleOpen, classifier, ignored], () => this.clear());
    watch([exampleOpen, classifier, ignored, state.shown, state.counts, state.playing], () =>
      this.ask(),
    );
    watch([shows, question], () => this.showAgain());
    watch([state.sequence], () => this.openedAnother());
    follow(() => {
      const choice = answer.value;
      answer.value = null;
      if (choice !== null) this.carryOut(choice);
    });
  }

  /** Another recording is open: the place in doubt that led there stays. */
  private openedAnother(): void {
    const place = question.peek();
    if (place?.sequence === state.sequence.peek()?.id) showPlace();
    else if (state.opening.peek() !== place?.sequence) leaveQuestion();
  }

  /** Ask what is predicted of the frame on screen, once it rests. */
  private ask(): void {
    clearTimeout(this.timer);
    const frame = this.engine.frame();
    if (!exampleOpen.peek() || !classifier.peek() || !frame) return;
    const known = this.said.get(frame);
    predicted.value = known ? countOf(known) : null;
    const here = frame.large ? frame.loaded > 0 : frame.complete;
    if (state.playing.peek() || !here) return;
    this.timer = setTimeout(() => void this.fetch(frame), REST_MS);
  }

  /** Place of a large frame that is predicted; undefined: the frame is predicted whole. */
  private placeIn(frame: CloudFrame): number[] | undefined {
    if (!frame.large) return undefined;
    const { camera, room } = this.engine.viewer;
    return lookedAt(frame, camera, room)?.map((x, k) => x + this.engine.shift()[k]!);
  }

  private async fetch(frame: CloudFrame): Promise<void> {
    const place = this.placeIn(frame);
    if (frame.large) {
      // Chunks come and go while one looks at the same place: that is no reason to ask again.
      const wish = [frame, classifier.peek(), state.counts.peek(), String(place)];
      if (!place || wish.every((part, k) => part === this.asked[k])) return;
      this.asked = wish;
    }
    this.request?.abort();
    const request = (this.request = new AbortController());
    asking.value = true;
    try {
      const answer = await predict(frame.index, place, request.signal);
      if (request.signal.aborted || !exampleOpen.peek()) return;
      this.said.set(frame, answer);
      this.show(frame, answer);
    } catch (error) {
      if (request.signal.aborted) return;
      notify(
        'error',
        'The prediction failed',
        error instanceof ApiError ? error.message : String(error),
      );
    } finally {
      if (this.request === request) asking.value = false;
    }
  }

  private show(frame: CloudFrame, said: Prediction): void {
    const ids = idsOf(said, shows.peek());
    const place = question.peek();
    if (place?.frame === frame.index) {
      markRound(
        frame,
        place.centre.map((x, k) => x - this.engine.shift()[k]!),
        place.radius,
        said.numbers,
        ids,
      );
    }
    frame.predict({ numbers: said.numbers, ids });
    if (frame === this.engine.frame()) {
      predicted.value = countOf(said);
      this.engine.viewer.show(frame);
    }
  }

  private showAgain(): void {
    for (const frame of this.engine.playback.store.all()) {
      const said = this.said.get(frame);
      if (said && frame.predicted) this.show(frame, said);
    }
  }

  /** Forget what was predicted: by another classifier, or until the bar was closed. */
  private clear(): void {
    this.request?.abort();
    this.asked = [];
    predicted.value = null;
    const shown = this.engine.frame();
    const predicts = shown?.predicted != null;
    for (const frame of this.engine.playback.store.all()) {
      this.said.delete(frame);
      frame.predict(null);
    }
    if (shown && predicts) this.engine.viewer.show(shown);
  }

  /** Paint a ball of a class at the place in doubt, or ignore the place, and go to the next. */
  private carryOut(choice: Answer): void {
    const place = question.peek();
    if (!place) return;
    if (choice === 'none') {
      leaveQuestion();
      void ignore(place).then(nextDoubt);
      return;
    }
    const name = place.classes[choice]!;
    const label = labelOf(name, state.palette.peek());
    if (label) this.paint(place.centre, place.radius, label.id);
    else void actions.createLabel(name).then((id) => this.paint(place.centre, place.radius, id));
  }

  private paint(centre: readonly number[], radius: number, label: number): void {
    const stroke = this.engine.beginStroke({
      shape: 'sphere',
      tool: 'paint',
      radius,
      label,
      only_unlabeled: true,
    });
    const shift = this.engine.shift();
    const [x, y, z] = centre.map((value, k) => value - shift[k]!) as [number, number, number];
    stroke?.add({ origin: [x, y, z], direction: [0, 0, -1] });
    stroke?.end();
    void nextDoubt();
  }
}

/** Write `ASKED` for the points of a frame in a ball, local coordinates and metres. */
function markRound(
  { pieces }: CloudFrame,
  [x, y, z]: readonly number[],
  radius: number,
  numbers: Uint32Array | null,
  ids: Uint16Array,
): void {
  const mark = (number: number): void => {
    const at = numbers ? lowerBound(numbers, number) : number;
    if (!numbers || numbers[at] === number) ids[at] = ASKED;
  };
  for (const { words, origin, scale, first, count } of pieces) {
    for (let i = 0, w = 0; i < count; i++, w += 6) {
      const dx = origin[0] + words[w]! * scale[0] - x!;
      const dy = origin[1] + words[w + 1]! * scale[1] - y!;
      const dz = origin[2] + words[w + 2]! * scale[2] - z!;
      if (dx * dx + dy * dy + dz * dz <= radius * radius) mark(first + i);
    }
  }
}
