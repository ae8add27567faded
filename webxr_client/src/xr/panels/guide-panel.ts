/** The panel of the first minute: the next step, its instruction, and the controls to skip it. */
import { change } from '../../store/xr-settings';
import { SIZES } from '../drawing/sizes';
import { INK, type Ui } from '../drawing/ui';
import { Panel } from './panel';
import { questionOpen } from './timeline-tracking';

/** Ems: middles of the two lines, and the buttons' width and height. */
const [TITLE, HOW, BUTTON, HIGH] = [1.5, 3.8, 5.2, 2.1];

export class GuidePanel extends Panel {
  private how = '';

  constructor(private readonly guide: { title(): string; how(): string; next(): void }) {
    super({ width: 0.5, height: 0.11, pixelsPerMetre: 2000, em: SIZES.question.em }, 98);
  }

  /** The instruction depends on the held inputs; the panel is hidden during a question. */
  override update(now: number): void {
    this.mesh.visible = !questionOpen.peek();
    const how = this.guide.how();
    if (how !== this.how) this.touch();
    this.how = how;
    super.update(now);
  }

  protected override draw(ui: Ui): void {
    const { em, width, height } = ui;
    const [pad, right] = [em * 0.8, width - em * (2 * BUTTON + 0.4)];
    ui.area({ name: 'move', x: 0, y: 0, w: width, h: height, moves: true, plain: true });
    ui.text(this.guide.title(), pad, em * TITLE, { weight: 650, width: right - pad });
    ui.text(this.how, pad, em * HOW, { color: INK.accent, width: width - 2 * pad });
    const [w, h] = [em * (BUTTON - 0.3), em * HIGH];
    const [next, skip] = [
      { text: 'Next', strong: true },
      { text: 'Skip all', strong: true },
    ];
    ui.button(right, em * 0.4, w, h, next, () => this.guide.next());
    ui.button(right + em * BUTTON, em * 0.4, w, h, skip, () => change({ guide: false }));
  }
}
