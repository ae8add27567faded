/** The panel of a checked headset: the next task, its controls, and the finished tasks. */
import { actions } from '../store/actions';
import { state } from '../store/state';
import { watch } from '../store/watch';
import type { Cockpit } from '../xr/cockpit';
import { Panel } from '../xr/panels/panel';
import { SIZES } from '../xr/drawing/sizes';
import { INK, type Ui } from '../xr/drawing/ui';
import type { Inputs } from './inputs';
import { fail, leave, outcomeOf, outcomes, task, TASKS, tick, type Task } from './tasks';

const MARKS = { works: ['check', INK.good], fails: ['close', INK.bad], unknown: null } as const;
/** Ems from one row to the next, and columns of tasks. */
const ROW = 1.7;
const COLUMNS = 2;

export class CheckPanel extends Panel {
  private readonly unsubscribe: () => void;
  /** Of the inputs, as they are drawn. */
  private changes = -1;

  constructor(
    private readonly cockpit: Cockpit,
    private readonly inputs: Inputs,
  ) {
    super({ width: 0.62, height: 0.41, pixelsPerMetre: 1700, em: SIZES.check.em }, 97);
    this.unsubscribe = watch([outcomes, state.playing], this.touch);
  }

  override dispose(): void {
    this.unsubscribe();
    super.dispose();
  }

  override update(now: number): void {
    if (this.changes !== this.inputs.changes) this.touch();
    this.changes = this.inputs.changes;
    super.update(now);
  }

  protected override draw(ui: Ui): void {
    const { em, width } = ui;
    const pad = em * 0.8;
    const doing = task.value;
    ui.area({ name: 'move', x: 0, y: 0, w: width, h: em * 3.6, moves: true, plain: true });
    ui.text(doing?.title ?? 'All done', pad, em * 1.3, { weight: 650, size: 1.2 });
    const hint = doing
      ? this.hint(doing)
      : 'Leave VR. The page then sends the report to the server.';
    ui.text(hint, pad, em * 2.9, { color: INK.quiet, width: width - 2 * pad });
    TASKS.forEach((each, i) => this.drawTask(ui, each, i, each === doing));
    const below = em * (4.6 + (ROW * TASKS.length) / COLUMNS);
    this.drawInputs(ui, pad, below);
    this.drawButtons(ui, pad, ui.height - em * 2.9, doing);
  }

  private drawTask(ui: Ui, { name, title }: Task, i: number, now: boolean): void {
    const { em, width } = ui;
    const rows = TASKS.length / COLUMNS;
    const x = em * 0.8 + (Math.floor(i / rows) * width) / COLUMNS;
    const y = em * (4.6 + ROW * (i % rows));
    const mark = MARKS[outcomeOf(name).verdict];
    if (mark) ui.icon(mark[0], x, y - em * 0.6, em * 1.2, mark[1]);
    const color = now ? INK.accent : mark ? INK.text : INK.quiet;
    ui.text(title, x + em * 1.7, y, { color, weight: now ? 650 : 500 });
  }

  /** Write the buttons that were pressed so far, as feedback for each press. */
  private drawInputs(ui: Ui, x: number, y: number): void {
    const { em, width } = ui;
    this.inputs.reports.slice(0, 2).forEach(({ side, layout, pressed, joints }, i) => {
      const buttons = `buttons ${pressed.join(' ') || 'none yet'}`;
      const words = `${side}: ${layout}, ${joints ? `${joints} joints, ` : ''}${buttons}`;
      ui.text(words, x, y + em * ROW * i, { color: INK.quiet, width: width - 2 * x });
    });
  }

  private drawButtons(ui: Ui, x: number, y: number, doing: Task | null): void {
    const { em } = ui;
    const look = { strong: true } as const;
    let left = x;
    const button = (text: string, wide: number, act: () => void): void => {
      ui.button(left, y, em * (wide - 0.4), em * 2.2, { text, ...look }, act);
      left += em * wide;
    };
    if (!doing) button('Leave VR', 7, () => void actions.page.exitVR());
    else if (doing.name === 'felt') {
      button('Pulse', 5.5, () => this.pulse());
      button('Felt it', 6, () => tick('felt'));
      button('Nothing', 6.5, () => fail('felt'));
      button('Skip', 5, () => leave('felt'));
    } else {
      if (doing.name === 'play') button('Play', 5, () => actions.time.togglePlay());
      button('Does not work', 9.5, () => fail(doing.name));
      button('Skip', 5, () => leave(doing.name));
    }
  }

  private pulse(): void {
    for (const { pointer } of this.cockpit.pointers.bodies) pointer.pulse(1, 200);
  }

  /** Return the hint for the held input devices, or else for a panel. */
  private hint({ lesson, otherwise }: Task): string {
    const own = lesson && lesson !== 'paint' ? this.cockpit.pointers.hint(lesson) : null;
    return own ?? otherwise;
  }
}
