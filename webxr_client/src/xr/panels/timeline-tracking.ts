/** The row below the timeline: track labels, watch the run, review uncertain results. */
import { signal } from '@preact/signals';
import { trackableLabels } from '../../store/palette-list';
import { actions } from '../../store/actions';
import { halted, namesOf, stretch, unsure } from '../../engine/review';
import { frameRange, ordered } from '../../store/range';
import type { Job } from '../../protocol/messages';
import { canReview, state, trackingJob } from '../../store/state';
import { xrSettings } from '../../store/xr-settings';
import { lines } from '../drawing/lines';
import { INK, type Ui } from '../drawing/ui';

const SOME = 30;

/** The question panel asks about this frame: the row below the timeline does not ask as well. */
export const questionOpen = signal(false);

export function drawTracking(ui: Ui, frames: number, top: number): void {
  const row = new Row(ui, top);
  const job = trackingJob.peek();
  if (job) drawRun(row, job);
  else if (questionOpen.peek()) row.drawText('Answer the question beside the object', INK.warn);
  else if (unsure.peek().length > 0) drawDoubt(row, row, row);
  else if (halted.peek()?.at === state.frame.peek()) drawMended(row, row);
  else if (frameRange.peek()) drawRange(row);
  else drawOffers(row, frames);
}

/** Text at the left, buttons from the right; lengths in ems. */
export class Row {
  private right: number;

  constructor(
    readonly ui: Ui,
    private readonly top: number,
    /** Letters of a line of text; longer text goes on below. */
    private readonly letters = Infinity,
  ) {
    this.right = ui.width - ui.em * 0.5;
  }

  drawText(text: string, color: string = INK.text): void {
    const { em } = this.ui;
    const x = em * 0.8;
    lines(text, this.letters).forEach((line, i) => {
      const y = this.top + em * (1.2 + 1.5 * i);
      this.ui.text(line, x, y, { color, weight: 600, width: this.right - x - em });
    });
  }

  button(wide: number, look: Parameters<Ui['button']>[4], act: () => void): void {
    const { em } = this.ui;
    this.right -= wide * em;
    this.ui.button(this.right, this.top, (wide - 0.3) * em, em * 2.4, look, act);
  }

  /** Text at the left that answers. */
  choose(text: string, act: () => void): void {
    const { em } = this.ui;
    const look = { text, icon: 'swap', align: 'left' } as const;
    this.ui.button(em * 0.4, this.top, this.right - em * 0.8, em * 2.4, look, act);
  }

  bar(share: number): void {
    const { em } = this.ui;
    const y = this.top + em;
    const length = this.right - em * 12;
    this.ui.box(em * 11, y, length, em * 0.4, INK.line);
    this.ui.box(em * 11, y, length * Math.max(0.02, share), em * 0.4, INK.accent);
  }
}

function drawRun(row: Row, job: Job): void {
  row.button(8.5, { text: 'Cancel', icon: 'close', strong: true }, () => {
    void actions.tracking.cancelJob(job.id);
  });
  row.button(12.5, { text: 'Stop and keep', icon: 'check', strong: true }, () => {
    void actions.tracking.cancelJob(job.id, true);
  });
  if (job.progress > 0) row.bar(job.progress);
  const waits = job.progress === 0 && job.message;
  row.drawText(waits || `Tracking ${Math.round(job.progress * 100)} %`);
}

/**
 * Some label is doubtful in this frame: right as it is, also in the doubtful frames round it, or
 * paint it and go on.  The rows may be the same one.
 */
export function drawDoubt(textRow: Row, answerRow: Row, laterRow: Row): void {
  laterRow.button(9.5, { text: 'Continue', icon: 'track', strong: true }, () =>
    actions.tracking.continueRun(),
  );
  const disabled = !canReview.peek();
  const found = stretch.peek();
  if (found && found.stop > found.start) {
    const text = `All ${found.stop - found.start + 1} frames`;
    answerRow.button(10, { text, icon: 'check', strong: true, disabled }, () => {
      void actions.tracking.acceptStretch();
    });
  }
  answerRow.button(8.5, { text: 'Confirm', icon: 'check', on: true, disabled }, () => {
    void actions.tracking.acceptFrame();
  });
  const todo = disabled ? 'Correct it; reviewers can confirm it' : 'Correct or confirm it';
  textRow.drawText(`${namesOf(unsure.peek())}: doubtful. ${todo}`, INK.warn);
}

export function drawMended(textRow: Row, answerRow: Row): void {
  const run = halted.peek()!;
  if (run.stop !== run.at) {
    answerRow.button(13, { text: `Continue to ${run.stop}`, icon: 'track', on: true }, () => {
      actions.tracking.continueRun();
    });
  }
  textRow.drawText('Corrected: you can continue', INK.good);
}

function drawRange(row: Row): void {
  const range = frameRange.peek()!;
  const [from, to] = ordered(range);
  const labels = trackable(range.from);
  row.button(7.5, { icon: 'close', text: 'Range' }, () => (frameRange.value = null));
  row.button(
    14.5,
    { icon: 'track', text: `Frames ${from} – ${to}`, on: true, disabled: labels.length === 0 },
    () => track(labels, range.from, range.to),
  );
  offer(row, labels, range.from);
}

function drawOffers(row: Row, frames: number): void {
  const frame = state.frame.peek();
  const last = frames - 1;
  const labels = trackable(frame);
  const none = labels.length === 0;
  const go = (stop: number) => () => track(labels, frame, stop);
  const end = none || frame === last;
  row.button(8.2, { icon: 'next', text: 'To end', strong: true, disabled: end }, go(last));
  const some = Math.min(last, frame + SOME);
  row.button(9.8, { icon: 'track', text: `${SOME} frames`, strong: true, disabled: end }, go(some));
  const start = none || frame === 0;
  row.button(8.8, { icon: 'previous', text: 'To start', strong: true, disabled: start }, go(0));
  offer(row, labels, frame);
}

/** Button to track the active label or all labels of the frame. */
function offer(row: Row, labels: readonly number[], frame: number): void {
  if (labels.length === 0) {
    row.drawText('Paint, then track it', INK.quiet);
    return;
  }
  const what = labels.length === 1 ? namesOf(labels) : `${labels.length} labels`;
  if (trackableLabels(frame).length < 2) row.drawText(`Track ${what}`);
  else row.choose(`Track ${what}`, () => (all.value = !all.peek()));
}

function track(labels: number[], start: number, stop: number): void {
  actions.tracking.track({ labels, start, stop, stop_unsure: xrSettings.peek().stopUnsure });
}

/** Track all labels of the frame rather than the active one. */
const all = signal(false);

/** The active label if it is in the frame and wanted alone, else every unlocked one that is. */
function trackable(frame: number): number[] {
  const present = trackableLabels(frame);
  const active = state.activeLabel.peek();
  return present.includes(active) && !all.peek() ? [active] : present;
}
