/** A participant's session: the current step, its time, and its limits of the page. */
import { studyCode } from '../common/checking';
import type { Engine } from '../engine/engine';
import { attempt } from '../engine/recordings/recordings';
import { api, ApiError } from '../net/rest';
import type { LogPosition, LogRecord, StudyStep } from '../protocol/values';
import { actions } from '../store/actions';
import { type Limits, limits, offers } from '../store/limits';
import { frameRange } from '../store/range';
import { patch, state } from '../store/state';
import { until } from '../store/watch';
import { change } from '../store/xr-settings';
import { DESK_WAYS } from '../tools/ways';
import type { Headset } from '../xr/headset';
import { Log } from './log';
import { observe } from './observer';
import { activeStep, finishing, isTask, isWorn, secondsLeft } from './step';

/** From one look at the server to the next, milliseconds: pauses, limits, and the log. */
const EVERY_MS = 2000;
const SECOND_MS = 1000;

const ROOT = `study/${studyCode() ?? ''}`;

let engine: Engine;
let headset: Headset;
let Bar: Limits['Bar'];
let log: Log | null = null;
let stopObserving = (): void => undefined;
/** Time of the newest answer, and of the step's beginning: `performance.now()`. */
let received = 0;
let began = 0;

/** Lead the participant through the study; `bar`: the tool bar during its steps. */
export function startSession(of: Engine, worn: Headset, bar: Limits['Bar']): void {
  [engine, headset, Bar] = [of, worn, bar];
  setInterval(() => void refresh(), EVERY_MS);
  setInterval(count, SECOND_MS);
  addEventListener('pagehide', () => log?.keep());
  void refresh();
}

function refresh(): Promise<void> {
  return finishing.peek() ? Promise.resolve() : attempt('The study cannot go on', update);
}

/** Send the log and fetch the current step; a server that does not answer is asked again. */
async function update(): Promise<void> {
  const before = activeStep.peek();
  try {
    await log?.flush();
    const next = await (before ? api<StudyStep>('GET', `${ROOT}/step`) : enter());
    // A step that was finished meanwhile is over.
    if (activeStep.peek() !== before) return;
    take(next);
    if (next.reached && isTask(next)) void finish([]);
  } catch (error) {
    if (!(error instanceof ApiError && error.status === 0)) throw error;
  }
}

/** Exchange the code for the page's cookie, with which the socket opens. */
async function enter(): Promise<StudyStep> {
  const first = await api<StudyStep>('POST', ROOT);
  log = new Log(first.records, `pointbrush.${ROOT}`, (records) =>
    api<LogPosition>('POST', `${ROOT}/log`, records),
  );
  engine.link.connect();
  return first;
}

function take(next: StudyStep): void {
  const before = activeStep.peek();
  received = performance.now();
  activeStep.value = next;
  count();
  if (before?.number === next.number && before.kind === next.kind) return;
  stopObserving();
  began = received - 1000 * next.elapsed_s;
  begin(next);
}

function count(): void {
  const step = activeStep.peek();
  const left = step && isTask(step) ? step.time_left_s : null;
  const seconds = left === null ? null : left - (performance.now() - received) / 1000;
  secondsLeft.value = seconds === null ? null : Math.max(0, Math.ceil(seconds));
  if (seconds !== null && seconds <= 0) void finish([]);
}

function begin(next: StudyStep): void {
  const { condition, sequence } = next;
  const tools = isTask(next) ? (condition?.tools ?? []) : null;
  limits.value = { tools, hints: condition?.hints ?? true, Bar };
  actions.tools.setTool('navigate');
  if (condition) change({ hands: condition.input === 'hands', guide: false });
  if (sequence) void show(next, sequence);
  if (next.kind === 'done') actions.recordings.closeSequence();
}

/** Open the recording of a task; the observer begins with its first picture. */
async function show(task: StudyStep, sequence: string): Promise<void> {
  actions.recordings.openSequence(sequence);
  await until(() => {
    const isOpen = state.sequence.value?.id === sequence && state.palette.value.length > 0;
    return isOpen && state.shown.value.total > 0;
  });
  // Another step may have begun meanwhile.
  const { number, kind } = activeStep.peek() ?? task;
  if (number === task.number && kind === task.kind && isTask(task)) prepare(task);
}

function prepare(task: StudyStep): void {
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
  stopObserving = observe(engine, headset, isWorn(task), (fields) => note(number, fields));
}

function note(number: number, fields: Omit<LogRecord, 'step' | 't'>): void {
  if (finishing.peek()) return;
  const t = Math.max(0, Math.round(performance.now() - began));
  log?.add({ ...fields, step: number, t });
}

/** Finish the current step, once all of it is on the server, and take the next one. */
export async function finish(answers: readonly number[]): Promise<void> {
  const number = activeStep.peek()?.number;
  if (finishing.peek() || number === undefined) return;
  finishing.value = true;
  // No stroke begins that the log would miss.
  const tool = state.tool.peek();
  actions.tools.setTool('navigate');
  await attempt('The step was not finished; try again', async () => {
    // The server has answered every edit.
    await until(() => state.pending.value === 0);
    await log?.flush();
    take(await api<StudyStep>('POST', `${ROOT}/step`, { number, answers }));
  });
  if (activeStep.peek()?.number === number) actions.tools.setTool(tool);
  finishing.value = false;
}
