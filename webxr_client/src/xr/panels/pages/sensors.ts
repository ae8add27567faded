/** Sensors of a recording of several: shown or hidden, and their colours. */
import { aligned, aligning, alignSensors } from '../../../engine/align-sensors';
import { colourBySensor, hiddenSensors, sensors, showSensor } from '../../../store/sensors';
import { canManage, state } from '../../../store/state';
import type { Entry, Ui } from '../../drawing/ui';
import { Rows } from './rows';

/** Rows in sight, and ems from one to the next. */
const [ROWS, PITCH] = [6, 2.4];

export class SensorsPage {
  private readonly rows: Rows;

  constructor(
    touch: () => void,
    private readonly back: () => void,
  ) {
    this.rows = new Rows(touch, ROWS);
  }

  draw(ui: Ui, x: number, top: number, inner: number): void {
    const { em } = ui;
    const all = sensors.peek();
    this.rows.of(all).forEach(({ number, name, kind, color }, i) => {
      const hidden = hiddenSensors.peek().has(number);
      const look = {
        icon: hidden ? 'hidden' : 'eye',
        swatch: color,
        text: name,
        note: kind,
      } as const;
      const place = [x, top + em * PITCH * i, inner, em * 2.2] as const;
      ui.button(...place, { ...look, strong: !hidden, align: 'left' }, () => showSensor(number, hidden)); // prettier-ignore
    });
    const below = top + em * (PITCH * Math.min(ROWS, all.length) + 0.2);
    const coloured = state.view.peek().color === 'sensor';
    ui.check(x, below, inner, em * 2.1, 'Colour by sensor', coloured, colourBySensor);
    ui.strip(x, below + em * 2.5, inner, em * 3, [
      [{ text: 'Back', icon: 'back' }, this.back],
      ...alignment(),
      ...(all.length > ROWS ? this.rows.turning(all.length) : []),
    ]);
  }
}

function alignment(): Entry[] {
  if (!canManage.peek()) return [];
  const disabled = aligning.peek();
  const align: Entry = [{ icon: 'target', text: 'Align', disabled }, () => void alignSensors()];
  const undo: Entry = [
    { icon: 'undo', text: 'Undo align', disabled },
    () => void alignSensors(true),
  ];
  return aligned.peek() ? [align, undo] : [align];
}
