/** A participant's session: the current step, its time, and what it makes of the page. */
import { studyCode } from '../common/checking';
import type { Engine } from '../engine/engine';
import { attempt } from '../engine/recordings/recordings';
import { api, ApiError } from '../net/rest';
import type { LogPosition, LogRecord, StudyStep } from '../protocol/values';
import { actions } from '../store/actions';
import { limits, offers } from '../store/limits';
import { frameRange } from '../store/range';
import { patch, state } from '../store/state';
import { until } from '../store/watch';
import { change } from '../store/xr-settings';
import { DESK_WAYS } from '../tools/ways';
import type { Headset } from '../xr/headset';
import { Log } from './log';
import { observe } from './observer';
import { StudyBar } from './bar';
import { activeStep, bindFinish, finishing, isTask, isWorn, secondsLeft } from './step';

/** From one look at the server to the next, milliseconds: pauses, limits, and the log. */
const EVERY_MS = 2000;
const SECOND_MS = 1000;

const ROOT = `study/${studyCode() ?? ''}`;

export class Session {
  private log: Log | null = null;
  private stopObserving = (): void => undefined;
  /** Time of the newest answer, and of the step's beginning: `performance.now()`. */
  private received = 0;
  private began = 0;
  private newest: StudyStep | null = null;

  constructor(
    private readonly engine: Engine,
    private readonly headset: Headset,
  ) {
    bindFinish((answers) => this.finish(answers));
    setInterval(() => void this.refresh(), EVERY_MS);
    setInterval(() => this.count(), SECOND_MS);
    addEventListener('pagehide', () => this.log?.keep());
    void this.refresh();
  }

  private refresh(): Promise<void> {
    if (finishing.peek()) return Promise.resolve();
    return attempt('The study cannot go on', () => this.update());
  }

  /** Send the log and fetch the current step; a server that does not answer is asked again. */
  private async update(): Promise<void> {
    const before = this.newest;
    try {
      await this.log?.flush();
      const next = await (before ? api<StudyStep>('GET', `${ROOT}/step`) : this.enter());
      // A step that was finished meanwhile is over.
      if (this.newest === before) this.take(next);
      if (this.newest?.reached && isTask(this.newest)) void this.finish([]);
    } catch (error) {
      if (!(error instanceof ApiError && error.status === 0)) throw error;
    }
  }

  /** Exchange the code for the page's cookie, with which the socket opens. */
  private async enter(): Promise<StudyStep> {
    const first = await api<StudyStep>('POST', ROOT);
    this.engine.link.connect();
    return first;
  }

  private take(next: StudyStep): void {
    const before = activeStep.peek();
    this.received = performance.now();
    this.newest = next;
    this.count();
    this.log ??= new Log(next.records, `pointbrush.${ROOT}`, (records) =>
      api<LogPosition>('POST', `${ROOT}/log`, records),
    );
    if (before?.number === next.number && before.kind === next.kind) return;
    this.stopObserving();
    this.began = this.received - 1000 * next.elapsed_s;
    activeStep.value = next;
    this.begin(next);
  }

  private count(): void {
    const left = this.newest?.time_left_s ?? null;
    const seconds = left === null ? null : left - (performance.now() - this.received) / 1000;
    secondsLeft.value = seconds === null ? null : Math.max(0, Math.ceil(seconds));
    if (seconds !== null && seconds <= 0) void this.finish([]);
  }

  private begin(next: StudyStep): void {
    const { condition, sequence } = next;
    const tools = isTask(next) ? (condition?.tools ?? []) : null;
    limits.value = { tools, hints: condition?.hints ?? true, Bar: StudyBar };
    actions.tools.setTool('navigate');
    if (condition) change({ hands: condition.input !== 'controller', guide: false });
    if (sequence) void this.show(next, sequence);
  }

  /** Open the recording of a task; the observer begins with its first picture. */
  private async show(task: StudyStep, sequence: string): Promise<void> {
    actions.recordings.openSequence(sequence);
    await until(() => {
      const isOpen = state.sequence.value?.id === sequence && state.palette.value.length > 0;
      return isOpen && state.shown.value.total > 0;
    });
    // Another step may have begun meanwhile.
    if (activeStep.peek() === task && isTask(task)) this.prepare(task);
  }

  private prepare(task: StudyStep): void {
    const { number, start, stop, labels } = task;
    const frames = state.sequence.peek()?.frames ?? 0;
    frameRange.value = stop - start < frames ? { from: start, to: stop - 1 } : null;
    if (state.frame.peek() < start || state.frame.peek() >= stop) actions.time.seek(start);
    if (!labels.includes(state.activeLabel.peek())) actions.labels.selectLabel(labels[0] ?? 0);
    actions.tools.setTool('paint');
    if (!offers(state.brush.peek().shape)) {
      const way = DESK_WAYS.find(({ shape }) => offers(shape));
      if (way) actions.tools.setShape(way.shape);
    }
    patch(state.brush, { complete: offers('object'), follow: false });
    this.stopObserving = observe(this.engine, this.headset, isWorn(task), (fields) =>
      this.note(number, fields),
    );
  }

  private note(number: number, fields: Omit<LogRecord, 'step' | 't'>): void {
    if (finishing.peek()) return;
    const t = Math.max(0, Math.round(performance.now() - this.began));
    this.log?.add({ ...fields, step: number, t });
  }

  /** Finish the current step, once all of it is on the server, and take the next one. */
  private async finish(answers: readonly number[]): Promise<void> {
    const number = activeStep.peek()?.number;
    if (finishing.peek() || number === undefined) return;
    finishing.value = true;
    // No stroke begins that the log would miss.
    const tool = state.tool.peek();
    actions.tools.setTool('navigate');
    await attempt('The step was not finished; try again', async () => {
      // The server has answered every edit.
      await until(() => state.pending.value === 0);
      await this.log?.flush();
      this.take(await api<StudyStep>('POST', `${ROOT}/step`, { number, answers }));
    });
    if (activeStep.peek()?.number === number) actions.tools.setTool(tool);
    finishing.value = false;
  }
}
