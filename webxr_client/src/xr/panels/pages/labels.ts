/** The palette's first page: a colour chip of each label, and actions on the active one. */
import { actions } from '../../../store/actions';
import type { Label } from '../../../protocol/messages';
import { findPeople } from '../../../engine/find-people';
import { unsure } from '../../../engine/review';
import { shortCount } from '../../../common/format';
import { hasDepth } from '../../../store/sensors';
import { activeLabel, state } from '../../../store/state';
import { INK, type Entry, type Ui } from '../../drawing/ui';
import { Rows } from './rows';

/** Chips beside one another, and in sight. */
const COLUMNS = 3;
export const CHIPS = 4 * COLUMNS;
/** Ems: from one chip to the next below, between two, and the height of a strip. */
const [PITCH, GAP, STRIP] = [3.2, 0.25, 3];

/** A place on the panel, pixels. */
interface Place {
  readonly x: number;
  readonly y: number;
  readonly w: number;
  readonly h: number;
}

export class LabelsPage {
  /** Places of the chips in sight, by label; for the glow. */
  readonly chips = new Map<number, Place>();
  private readonly rows: Rows;
  /** The active label when this was drawn last: another one is brought into sight. */
  private active = 0;

  constructor(
    touch: () => void,
    private readonly makeNew: () => void,
    /** Change the active label. */
    private readonly edit: () => void,
  ) {
    this.rows = new Rows(touch, CHIPS);
  }

  draw(ui: Ui, x: number, top: number, inner: number): void {
    const { em } = ui;
    const palette = state.palette.peek();
    this.follow(palette);
    this.chips.clear();
    const wide = inner / COLUMNS;
    this.rows.of(palette).forEach((label, i) => {
      const [column, line] = [i % COLUMNS, Math.floor(i / COLUMNS)];
      const [left, y] = [x + column * wide, top + line * PITCH * em];
      this.drawChip(ui, label, { x: left, y, w: wide - GAP * em, h: (PITCH - GAP) * em });
    });
    if (palette.length === 0) {
      ui.text('One label per object or class.', x + em * 0.4, top + em * 1.5, { color: INK.quiet });
    }
    this.drawBelow(ui, x, top + (CHIPS / COLUMNS) * PITCH * em, inner - GAP * em);
  }

  private follow(palette: readonly Label[]): void {
    const active = state.activeLabel.peek();
    const place = palette.findIndex(({ id }) => id === active);
    if (active === this.active || place < 0) return;
    this.active = active;
    this.rows.show(place);
  }

  private drawChip(ui: Ui, label: Label, place: Place): void {
    const { em } = ui;
    const { x, y, w, h } = place;
    this.chips.set(label.id, place);
    const on = label.id === state.activeLabel.peek();
    const icon = label.locked ? 'lock' : label.visible ? null : 'hidden';
    const look = { fill: label.color, faded: !label.visible, text: label.name, on } as const;
    ui.button(x, y, w, h, { ...look, ...(icon && { icon }), align: 'left' }, () => {
      actions.labels.selectLabel(label.id);
      if (state.tool.peek() === 'pick') actions.tools.setTool('paint');
    });
    if (!unsure.peek().includes(label.id)) return;
    ui.box(x + w - em * 1.9, y + em * 0.2, em * 1.7, em * 1.5, INK.back);
    ui.icon('warning', x + w - em * 1.7, y + em * 0.3, em * 1.3, INK.warn);
  }

  private drawBelow(ui: Ui, x: number, y: number, inner: number): void {
    const { em } = ui;
    const label = activeLabel.peek();
    if (label) drawHeading(ui, label, x, y, inner);
    const below = y + em * 1.9;
    ui.strip(x, below, inner, em * STRIP, choices(label));
    ui.strip(x, below + em * (STRIP + GAP), inner, em * STRIP, [
      [{ icon: 'plus', text: 'New' }, this.makeNew],
      [{ icon: 'pencil', text: 'Edit', disabled: !label }, this.edit],
      [{ icon: 'people', text: 'People', disabled: !hasDepth.peek() }, () => void findPeople()],
      ...this.rows.turning(state.palette.peek().length),
    ]);
  }
}

/** The active label: its name, and the count of its points in the whole recording, which no step changes. */
function drawHeading(ui: Ui, { id, name, category }: Label, x: number, y: number, inner: number): void {
  const { em } = ui;
  const count = state.counts.peek().get(id) ?? 0;
  const note = count > 0 ? `${shortCount(count)} in all` : category;
  ui.text(name, x + em * 0.4, y + em * 0.9, { weight: 600, width: inner * 0.6 });
  ui.text(note, x + inner - em * 0.4, y + em * 0.9, { color: INK.quiet, align: 'right' });
} // prettier-ignore

/** Actions for the active label, and the choice of another one in the recording. */
function choices(label: Label | null): Entry[] {
  const { id = 0, locked = false, visible = true } = label ?? {};
  const solo = state.solo.peek() === id;
  const picking = state.tool.peek() === 'pick';
  const disabled = !label;
  return [
    [{ icon: locked ? 'lock' : 'unlock', text: 'Lock', on: locked, disabled }, () => void actions.labels.toggleLock(id)],
    [{ icon: visible ? 'eye' : 'hidden', text: 'Hide', on: !visible, disabled }, () => void actions.labels.toggleVisible(id)],
    [{ icon: 'solo', text: 'Solo', on: solo && !disabled, disabled }, () => actions.labels.solo(solo ? null : id)],
    [{ icon: 'picker', text: 'Pick', on: picking }, () => actions.tools.setTool(picking ? 'paint' : 'pick')],
  ];
} // prettier-ignore
