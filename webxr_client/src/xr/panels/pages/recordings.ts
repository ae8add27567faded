/** The server's recordings, to open another one. */
import { actions } from '../../../store/actions';
import { plural } from '../../../common/format';
import { state } from '../../../store/state';
import { INK, type Ui } from '../../drawing/ui';
import { Rows } from './rows';

/** Rows in sight, and ems from one to the next. */
const [ROWS, PITCH] = [7, 2.4];

export class RecordingsPage {
  private readonly rows: Rows;

  constructor(
    touch: () => void,
    private readonly back: () => void,
  ) {
    this.rows = new Rows(touch, ROWS);
  }

  draw(ui: Ui, x: number, top: number, inner: number): void {
    const { em } = ui;
    const sound = (state.sequences.peek() ?? []).filter(({ damaged }) => damaged === null);
    const open = state.sequence.peek()?.id;
    this.rows.of(sound).forEach(({ id, name, frames }, i) => {
      const look = { text: name, note: plural(frames, 'frame'), on: id === open } as const;
      const place = [x, top + em * PITCH * i, inner, em * 2.2] as const;
      ui.button(...place, { ...look, strong: true, align: 'left' }, () =>
        actions.recordings.openSequence(id),
      );
    });
    if (sound.length === 0) {
      ui.text('No recordings yet.', x + em * 0.5, top + em * 1.5, { color: INK.quiet });
    }
    ui.strip(x, top + em * (PITCH * ROWS + 0.3), inner, em * 3, [
      [{ text: 'Back', icon: 'back' }, this.back],
      ...this.rows.turning(sound.length),
    ]);
  }
}
