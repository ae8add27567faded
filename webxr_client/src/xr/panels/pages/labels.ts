/** The palette's first page: every label, to choose, lock, hide or see alone. */
import { actions } from '../../../store/actions';
import type { Label } from '../../../protocol/messages';
import { unsure } from '../../../engine/review';
import { shortCount } from '../../../common/format';
import { activeLabel, state } from '../../../store/state';
import { INK, type Ui } from '../../drawing/ui';
import { ROWS, Rows } from './rows';

/** Ems: an icon that answers is as wide as a finger needs. */
const ICON_EMS = 1.7;

export class LabelsPage {
  /** Pixels from the top of the first row, and from one row to the next; for the glow. */
  top = 0;
  row = 0;
  private readonly rows: Rows;
  /** The active label when this was drawn last: another one is brought into sight. */
  private active = 0;

  constructor(
    touch: () => void,
    private readonly makeNew: () => void,
    /** Change the active label. */
    private readonly edit: () => void,
  ) {
    this.rows = new Rows(touch);
  }

  /** The row that a label is drawn in, or −1. */
  rowOf(label: number): number {
    const place = state.palette.peek().findIndex((entry) => entry.id === label) - this.rows.first;
    return place >= 0 && place < ROWS ? place : -1;
  }

  draw(ui: Ui, x: number, top: number, inner: number): void {
    const { em } = ui;
    const palette = state.palette.peek();
    this.follow(palette);
    const row = em * 2.35;
    this.top = top;
    this.row = row;
    this.rows.of(palette).forEach((label, i) => {
      drawLabel(ui, label, x, top + i * row, inner, row - em * 0.15);
    });
    if (palette.length === 0) {
      ui.text('A label stands for one object.', x + em * 0.5, top + em * 1.5, {
        color: INK.quiet,
      });
    }
    this.drawBelow(ui, x, top + ROWS * row + em * 0.2, inner, palette.length > ROWS);
  }

  private follow(palette: readonly Label[]): void {
    const active = state.activeLabel.peek();
    const place = palette.findIndex(({ id }) => id === active);
    if (active === this.active || place < 0) return;
    this.active = active;
    this.rows.first = Math.min(place, Math.max(this.rows.first, place - ROWS + 1));
  }

  private drawBelow(ui: Ui, x: number, y: number, inner: number, more: boolean): void {
    const w = inner / 4;
    const h = ui.em * 2.2;
    ui.button(x, y, w * 0.92, h, { icon: 'plus', text: 'New', strong: true }, this.makeNew);
    const edit = { icon: 'pencil', text: 'Edit', strong: true } as const;
    const disabled = !activeLabel.peek();
    ui.button(x + w * 0.96, y, w * 0.92, h, { ...edit, disabled }, this.edit);
    const picking = state.tool.peek() === 'pick';
    ui.button(x + w * 1.92, y, w * 0.92, h, { icon: 'picker', text: 'Pick', on: picking }, () => {
      actions.setTool(picking ? 'paint' : 'pick');
    });
    this.rows.drawTurning(ui, x, y, inner, more);
  }
}

function drawLabel(ui: Ui, label: Label, x: number, y: number, w: number, h: number): void {
  const { em } = ui;
  const on = label.id === state.activeLabel.peek();
  const tools = 3 * em * ICON_EMS + em * 0.15;
  const doubtful = unsure.peek().includes(label.id);
  // The sign takes the category's place.
  const note = doubtful ? '' : on ? pointsIn(label) : label.category;
  ui.button(
    x,
    y,
    w - tools,
    h,
    { swatch: label.color, text: label.name, note, on, strong: true, align: 'left' },
    () => {
      actions.selectLabel(label.id);
      if (state.tool.peek() === 'pick') actions.setTool('paint');
    },
  );
  if (doubtful) {
    ui.icon('warning', x + w - tools - em * 1.9, y + (h - em * 1.3) / 2, em * 1.3, INK.warn);
  }
  const left = x + w - tools + em * 0.15;
  const size = em * ICON_EMS;
  const lock = { icon: label.locked ? 'lock' : 'unlock', on: label.locked } as const;
  const eye = { icon: label.visible ? 'eye' : 'hidden', on: !label.visible } as const;
  ui.button(left, y, size, h, lock, () => void actions.toggleLock(label.id));
  ui.button(left + size, y, size, h, eye, () => void actions.toggleVisible(label.id));
  const solo = state.solo.peek() === label.id;
  ui.button(left + 2 * size, y, size, h, { icon: 'solo', on: solo }, () =>
    actions.solo(solo ? null : label.id),
  );
}

/** Count of the active label's points in the whole recording, which no step through frames changes. */
function pointsIn({ id, category }: Label): string {
  const count = state.counts.peek().get(id) ?? 0;
  return count > 0 ? `${shortCount(count)} in all` : category;
}
