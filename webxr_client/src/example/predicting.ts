/** Shows the prediction of the frame on screen, and the place of the question. */
import { questionPiece, type Runs } from '../cameras/state';
import { QUESTION_ID } from '../cloud/picture/palette';
import type { CloudFrame } from '../cloud/points/frame';
import { lowerBound } from '../cloud/points/piece';
import { looked } from '../engine/labels/colouring';
import type { Engine } from '../engine/engine';
import { ApiError } from '../net/rest';
import { notify, state } from '../store/state';
import { follow, watch } from '../store/watch';
import { lookedAt } from './looking';
import { classOf, coloursOf, idsOf, mapColours, type Prediction } from './model';
import { isRequesting, classifier, exampleOpen, ignored, leaveQuestion, looking, natural, only, predict, predicted, question, showPlace } from './store'; // prettier-ignore

/** Edits and frames come one after the other: the server is asked once they rest, milliseconds. */
const REST_MS = 120;

export class Predicting {
  /** Predictions of the frames that are here. */
  private readonly predictions = new WeakMap<CloudFrame, Prediction>();
  private timer: ReturnType<typeof setTimeout> | undefined;
  private request: AbortController | null = null;
  /** Of large frames: the frame, classifier, labels and place that were asked about last. */
  private lastRequest: readonly unknown[] = [];

  constructor(private readonly engine: Engine) {
    const { palette } = engine.viewer;
    looking.at = () => {
      const frame = engine.frame();
      return frame ? this.placeIn(frame) : undefined;
    };
    looking.open = ({ numbers, kind }) => {
      const frame = engine.frame();
      return frame && kind.map((_, i) => (frame.storedLabelOf(numbers ? numbers[i]! : i) ? 0 : 1));
    };
    follow(() => {
      const classes = classifier.value?.classes ?? [];
      const alone = only.value;
      const chosen = classes.indexOf(alone ?? '');
      looked.value = chosen < 0 ? null : (label) => classOf(label) === alone;
      const colours = coloursOf(classes, state.palette.value);
      palette.setPredicted(mapColours(colours, chosen < 0 ? null : chosen));
      engine.viewer.invalidate();
    });
    follow(() => {
      const mapping = natural.value ? 'natural' : 'classes';
      engine.viewer.setMapping(exampleOpen.value ? mapping : 'view', question.value !== null);
    });
    watch([exampleOpen, classifier, ignored], () => this.clear());
    watch([exampleOpen, classifier, ignored, state.shown, state.counts, state.playing], () =>
      this.ask(),
    );
    watch([question], () => {
      questionPiece.value = question.peek();
      this.refresh();
    });
    watch([state.sequence], () => this.openedAnother());
  }

  /** Another recording is open: the place in doubt that led there stays. */
  private openedAnother(): void {
    const place = question.peek();
    if (place?.sequence === state.sequence.peek()?.id) showPlace();
    else if (state.opening.peek() !== place?.sequence) leaveQuestion();
  }

  /** Fetch the prediction of the frame on screen once the frame stays. */
  private ask(): void {
    clearTimeout(this.timer);
    const frame = this.engine.frame();
    if (!exampleOpen.peek() || !classifier.peek() || !frame) return;
    const known = this.predictions.get(frame);
    predicted.value = known ?? null;
    const isLoaded = frame.large ? frame.loaded > 0 : frame.complete;
    if (state.playing.peek() || !isLoaded) return;
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
      if (!place || wish.every((part, k) => part === this.lastRequest[k])) return;
      this.lastRequest = wish;
    }
    this.request?.abort();
    const request = (this.request = new AbortController());
    isRequesting.value = true;
    try {
      const answer = await predict(frame.index, place, request.signal);
      if (request.signal.aborted || !exampleOpen.peek()) return;
      this.predictions.set(frame, answer);
      this.show(frame, answer);
    } catch (error) {
      if (request.signal.aborted) return;
      notify(
        'error',
        'The prediction failed',
        error instanceof ApiError ? error.message : String(error),
      );
    } finally {
      if (this.request === request) isRequesting.value = false;
    }
  }

  private show(frame: CloudFrame, prediction: Prediction): void {
    const ids = idsOf(prediction);
    const place = question.peek();
    if (place?.frame === frame.index) mark(place.runs, prediction.numbers, ids);
    frame.predict({ numbers: prediction.numbers, ids });
    if (frame === this.engine.frame()) {
      predicted.value = prediction;
      this.engine.viewer.show(frame);
    }
  }

  private refresh(): void {
    for (const frame of this.engine.playback.store.all()) {
      const prediction = this.predictions.get(frame);
      if (prediction && frame.predicted) this.show(frame, prediction);
    }
  }

  /** Drop the prediction of another classifier, or of before the bar was closed. */
  private clear(): void {
    this.request?.abort();
    this.lastRequest = [];
    predicted.value = null;
    const shown = this.engine.frame();
    const predicts = shown?.predicted != null;
    for (const frame of this.engine.playback.store.all()) {
      this.predictions.delete(frame);
      frame.predict(null);
    }
    if (shown && predicts) this.engine.viewer.show(shown);
  }
}

/** Write `QUESTION_ID` for points by their runs; `numbers`: the points of `ids`, null: all. */
function mark(runs: Runs, numbers: Uint32Array | null, ids: Uint16Array): void {
  for (const [first, length] of runs) {
    const from = numbers ? lowerBound(numbers, first) : first;
    ids.fill(QUESTION_ID, from, numbers ? lowerBound(numbers, first + length) : first + length);
  }
}
