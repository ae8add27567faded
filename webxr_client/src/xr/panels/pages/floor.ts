/** Setting the floor: instruction, progress, and the way back. */
import { actions } from '../../../store/actions';
import { floorPlaces } from '../../../engine/floor';
import { INK, type Ui } from '../../drawing/ui';

const HOW = [
  'Point at the floor and press.',
  'The recording will stand on it.',
  'Two more places, far apart,',
  'level it better.',
];
const PROGRESS = ['Not set yet', 'Set by one place', 'Set by two places', 'Set by three places'];

export function drawFloor(ui: Ui, x: number, top: number, inner: number): void {
  const { em } = ui;
  ui.icon('plane', x + em * 0.4, top + em * 0.1, em * 2.2, INK.accent);
  ui.text('Set the floor', x + em * 3.2, top + em * 1.2, { size: 1.25, weight: 600 });
  HOW.forEach((line, i) => {
    ui.text(line, x + em * 0.4, top + em * (4 + 1.6 * i), { color: INK.quiet });
  });
  const places = floorPlaces.peek();
  const color = places > 0 ? INK.good : INK.quiet;
  ui.text(PROGRESS[places]!, x + em * 0.4, top + em * 11.4, { color, weight: 600 });
  const half = inner / 2;
  const look = { strong: true } as const;
  ui.button(x, top + em * 13, inner - em * 0.2, em * 2.2,
    { icon: 'restore', text: 'Reset to import', align: 'left', ...look },
    () => void actions.view.resetFloor()); // prettier-ignore
  ui.button(x + half, top + em * 15.6, half - em * 0.2, em * 2.2,
    { icon: 'check', text: 'Done', on: true }, () => actions.tools.setTool('paint')); // prettier-ignore
}
