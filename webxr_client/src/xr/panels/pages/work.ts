/** Page of the palette for tasks: the own one, the one to review, and an export for the desk. */
import { exportSequence, loadExportFormats } from '../../../engine/recordings/recordings';
import type { Task } from '../../../protocol/values';
import { lastExport, exportFormats } from '../../../engine/recordings/export-formats';
import { may, TASK_WORDS } from '../../../engine/recordings/projects';
import { notify, state } from '../../../store/state';
import {
  accept,
  begin,
  giveBack,
  goToTask,
  handIn,
  judged,
  mine,
  nextReview,
  nextTask,
  question,
  tasks,
  taskWords,
} from '../../../work/queue';
import { project } from '../../../work/store';
import { lines } from '../../drawing/lines';
import { type Entry, INK, type Ui } from '../../drawing/ui';
import type { AskName } from './writing';

/** Signals that the page shows. */
export const WORK = [tasks, mine, judged, question, project] as const;

/** Ems from one row to the next, from one line of text to the next, and letters of a line. */
const [PITCH, LINE, LETTERS] = [2.5, 1.5, 33];
/** Lines of a reviewer's note. */
const NOTE_LINES = 2;

export function drawWork(ui: Ui, x: number, top: number, inner: number, ask: AskName): void {
  const column = new Column(ui, x, top, inner);
  const pending = question.peek();
  const of = project.peek();
  if (pending) {
    column.drawText(
      `You have not changed anything in ${taskWords(pending.task)} since you got this task.`,
    );
    column.buttons([
      [{ text: 'Keep working', on: true }, () => pending.answer(false)],
      [{ text: 'Hand in anyway' }, () => pending.answer(true)],
    ]);
    return;
  }
  if (!of) column.drawText('Loading the tasks…');
  else {
    if (may(of, 'annotator')) drawOwn(column, of.id);
    else column.drawText('Your role in this project has no tasks.');
    if (may(of, 'reviewer')) drawReview(column, ask);
  }
  const open = state.sequence.peek() !== null;
  column.buttons([[{ icon: 'export', text: 'Export at the desk', disabled: !open }, keepExport]]);
}

/** Text and rows of buttons below one another. */
class Column {
  constructor(
    private readonly ui: Ui,
    private readonly x: number,
    private y: number,
    private readonly inner: number,
  ) {}

  drawText(text: string, color: string = INK.quiet, most = Infinity): void {
    const { em } = this.ui;
    for (const line of lines(text, LETTERS).slice(0, most)) {
      this.ui.text(line, this.x + em * 0.4, this.y + em * 0.8, { color, width: this.inner });
      this.y += LINE * em;
    }
  }

  buttons(entries: readonly Entry[]): void {
    const { em } = this.ui;
    const wide = this.inner / entries.length;
    entries.forEach(([look, run], i) => {
      const place = [this.x + i * wide, this.y + em * 0.1, wide - em * 0.2, em * 2.2] as const;
      this.ui.button(...place, { strong: true, align: 'left', ...look }, run);
    });
    this.y += PITCH * em;
  }
}

function drawOwn(column: Column, of: string): void {
  const [task] = mine.peek();
  if (!task) {
    const none = tasks.peek().length === 0;
    column.drawText(none ? 'This project has no tasks.' : 'No task started.');
    const look = { icon: 'next', text: 'Next task', on: !none, disabled: none } as const;
    column.buttons([[look, () => void begin(of)]]);
    return;
  }
  column.drawText(`My task, ${TASK_WORDS[task.state]}: ${taskWords(task)}`, INK.text);
  if (task.note) column.drawText(task.note, INK.warn, NOTE_LINES);
  column.buttons(stepsOf(task, of));
}

function stepsOf(task: Task, of: string): Entry[] {
  if (task.state === 'returned')
    return [[{ icon: 'next', text: 'Correct it', on: true }, () => void begin(of)]];
  if (task.sequence !== state.sequence.peek()?.id)
    return [[{ icon: 'folder', text: 'Open my task', on: true }, () => goToTask(task)]];
  return [
    [{ icon: 'check', text: 'Hand in', on: true }, () => void handIn(task)],
    [{ icon: 'next', text: 'Hand in, next' }, () => void nextTask()],
  ];
}

function drawReview(column: Column, ask: AskName): void {
  const task = judged.peek();
  if (task) drawVerdict(column, task, ask);
  const disabled = !tasks.peek().some((one) => one.state === 'done' || one.state === 'review');
  if (disabled) column.drawText('No task waits for a review.');
  column.buttons([[{ icon: 'people', text: 'Next to review', disabled }, () => void nextReview()]]);
}

function drawVerdict(column: Column, task: Task, ask: AskName): void {
  const by = task.assignee || 'no annotator';
  column.drawText(`${taskWords(task)}, by ${by}: ${TASK_WORDS[task.state]}`, INK.text);
  const give = (): void =>
    ask('Note for the correction', (note) => void giveBack(task, note, null));
  column.buttons([
    [
      { icon: 'check', text: 'Accept', disabled: task.state === 'accepted' },
      () => void accept(task),
    ],
    [{ icon: 'back', text: 'Return…' }, give],
  ]);
}

/** Keep a link to an export of the open recording in a notice at the desk: a download may end the session. */
function keepExport(): void {
  const info = state.sequence.peek()!;
  const run = async (): Promise<void> => {
    await loadExportFormats();
    const format = lastExport.peek() ?? exportFormats.peek()[0]?.format;
    if (format) await exportSequence(format, '', '', '', info.id);
  };
  const link = { label: 'Export', run: () => void run(), stays: true };
  notify('success', `Export of ${info.name}`, 'The link waits on the page. Leave the headset to use it.', link); // prettier-ignore
}
