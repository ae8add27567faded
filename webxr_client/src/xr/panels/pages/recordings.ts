/** The server's recordings, to open another one. */
import { actions } from '../../../store/actions';
import { plural } from '../../../common/format';
import { state } from '../../../store/state';
import { INK, type Ui } from '../../drawing/ui';
import { ROWS, Rows } from './rows';

/** Ems from one row to the next. */
const PITCH = 2.35;

export class RecordingsPage {
  private readonly rows: Rows;

  constructor(
    touch: () => void,
    private readonly back: () => void,
  ) {
    this.rows = new Rows(touch);
  }

  draw(ui: Ui, x: number, top: number, inner: number): void {
    const { em } = ui;
    const sound = (state.sequences.peek() ?? []).filter(({ damaged }) => damaged === null);
    const open = state.sequence.peek()?.id;
    this.rows.of(sound).forEach(({ id, name, frames }, i) => {
      const look = { text: name, note: plural(frames, 'frame'), on: id === open } as const;
      const place = [x, top + em * PITCH * i, inner - em * 0.2, em * 2.2] as const;
      ui.button(...place, { ...look, strong: true, align: 'left' }, () => actions.openSequence(id));
    });
    if (sound.length === 0) {
      ui.text('No recordings yet.', x + em * 0.5, top + em * 1.5, { color: INK.quiet });
    }
    this.drawBelow(ui, x, top + em * (PITCH * ROWS + 0.2), inner, sound.length > ROWS);
  }

  private drawBelow(ui: Ui, x: number, y: number, inner: number, more: boolean): void {
    const w = inner / 4;
    const h = ui.em * 2.2;
    ui.button(x, y, w * 1.4, h, { text: 'Back', icon: 'back' }, this.back);
    this.rows.drawTurning(ui, x, y, inner, more);
  }
}
