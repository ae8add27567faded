/** Pages of one label: a new one, or the active one with another name, another colour, or gone. */
import { actions } from '../../../store/actions';
import { LABEL_COLORS, suggestColor, suggestName } from '../../../common/colors';
import { categoriesSelected, categoryChoices } from '../../../engine/labels/categories';
import { lossOf } from '../../../panels/labels/label-points';
import type { Label } from '../../../protocol/messages';
import { state } from '../../../store/state';
import { watch } from '../../../store/watch';
import { INK, type Ui } from '../../drawing/ui';
import type { AskName } from './writing';

/** Quick names, each with a colour unlike the others, or one that is typed. */
export function drawNew(
  ui: Ui,
  x: number,
  top: number,
  inner: number,
  ask: AskName,
  back: () => void,
): void {
  const { em } = ui;
  const color = suggestColor(state.palette.peek().map((label) => label.color));
  const make = (name: string, category: string): void => {
    void actions.labels.createLabel(name, color, category);
    actions.tools.setTool('paint');
    back();
  };
  ui.text('Choose a name', x + em * 0.4, top + em * 0.8, { color: INK.quiet });
  drawNames(ui, [x, top + em * 1.9, inner], 5, color, make);
  const y = top + em * 14.4;
  const h = em * 2.1;
  ui.button(x, y, inner / 3, h, { text: 'Back', icon: 'previous' }, back);
  const type = { text: 'Type a name', icon: 'pencil', strong: true } as const;
  ui.button(x + inner / 2, y, inner / 2 - em * 0.25, h, type, () => {
    ask('Name of the new label', (name) => make(name, ''));
  });
}

/** Swatches in a line. */
const SWATCHES = 8;
/** Ems: from one line of names or swatches to the next, its height, and where the colours and the last line begin. */
const [PITCH, HEIGHT, COLORS, END] = [2.4, 2.2, 12.4, 17.8];

/** The active label: another name, another colour, or gone. */
export class EditPage {
  /** The label that was asked to be deleted; 0: none. */
  private labelToDelete = 0;
  private readonly unsubscribe: () => void;

  constructor(
    private readonly touch: () => void,
    private readonly ask: AskName,
    private readonly back: () => void,
  ) {
    // The question counts points of the frame that is shown.
    this.unsubscribe = watch(
      [state.frame, state.timeline],
      () => this.labelToDelete !== 0 && touch(),
    );
  }

  dispose(): void {
    this.unsubscribe();
  }

  /** The page is turned to: nothing was asked. */
  begin(): void {
    this.labelToDelete = 0;
  }

  draw(ui: Ui, x: number, top: number, inner: number, label: Label): void {
    const { em } = ui;
    ui.box(x + em * 0.4, top + em * 0.25, em * 1.4, em * 1.4, label.color);
    const heading = { size: 1.25, weight: 600, width: inner - em * 2.8 };
    ui.text(label.name, x + em * 2.4, top + em, heading);
    if (this.labelToDelete === label.id) this.drawQuestion(ui, x, top, inner, label);
    else this.drawChoices(ui, x, top, inner, label);
  }

  private drawChoices(ui: Ui, x: number, top: number, inner: number, label: Label): void {
    const { em } = ui;
    this.labelToDelete = 0;
    drawNames(ui, [x, top + em * 2.4, inner], 4, label.color, (name, category) => {
      void actions.labels.updateLabel(label.id, { name, category });
    });
    const w = inner / SWATCHES;
    LABEL_COLORS.forEach((swatch, i) => {
      const y = top + em * (COLORS + PITCH * Math.floor(i / SWATCHES));
      const look = { swatch, on: swatch === label.color.toLowerCase(), strong: true };
      ui.button(x + (i % SWATCHES) * w, y, w - em * 0.2, em * HEIGHT, look, () => {
        void actions.labels.recolorLabel(label.id, swatch);
      });
    });
    const third = inner / 3;
    const y = top + em * END;
    const [wide, h] = [third - em * 0.2, em * HEIGHT];
    ui.button(x, y, wide, h, { text: 'Back', icon: 'previous' }, this.back);
    const type = { text: 'Type', icon: 'pencil', strong: true } as const;
    ui.button(x + third, y, wide, h, type, () => {
      this.ask(
        `Name of “${label.name}”`,
        (name) => void actions.labels.renameLabel(label.id, name),
      );
    });
    const remove = { text: 'Delete', icon: 'trash', strong: true } as const;
    ui.button(x + 2 * third, y, wide, h, remove, () => this.doom(label.id));
  }

  private drawQuestion(ui: Ui, x: number, top: number, inner: number, label: Label): void {
    const { em } = ui;
    const [inFrame, all] = lossOf(label.id);
    const lines = ['Delete this label?', inFrame, all, 'will be unlabelled. This can be undone.'];
    lines.forEach((line, i) => {
      ui.text(line, x + em * 0.4, top + em * (4 + 1.6 * i), { color: INK.quiet });
    });
    const half = inner / 2;
    const [y, wide, h] = [top + em * END, half - em * 0.2, em * HEIGHT];
    ui.button(x, y, wide, h, { text: 'Keep', icon: 'previous', strong: true }, () => this.doom(0));
    ui.button(x + half, y, wide, h, { text: 'Delete it', icon: 'trash', strong: true }, () => {
      this.doom(0);
      void actions.labels.deleteLabel(label.id);
      this.back();
    });
  }

  private doom(label: number): void {
    this.labelToDelete = label;
    this.touch();
  }
}

/** Names that need no keyboard: categories to choose from, then common ones; each counts on. */
const QUICK = ['pin', 'hand', 'person', 'ball', 'head', 'object', 'vehicle', 'table'];

type TakeName = (name: string, category: string) => void;

/** Lay out names in so many lines of two, each with the colour that it is for. */
function drawNames(
  ui: Ui,
  [x, y, inner]: readonly [x: number, y: number, inner: number],
  lines: number,
  color: string,
  take: TakeName,
): void {
  const { em } = ui;
  const names = state.palette.peek().map((label) => label.name);
  const common = categoriesSelected.peek() ? [] : QUICK;
  const choices = [...new Set([...categoryChoices.peek(), ...common])].slice(0, 2 * lines);
  const w = inner / 2;
  choices.forEach((category, i) => {
    const name = suggestName(category, names);
    const [left, top] = [x + (i % 2) * w, y + em * PITCH * Math.floor(i / 2)];
    const look = { swatch: color, text: name, strong: true, align: 'left' } as const;
    ui.button(left, top, w - em * 0.25, em * 2.2, look, () => take(name, category));
  });
}
