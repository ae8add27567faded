/** A new label: quick names, each with a colour unlike the others, or one that is typed. */
import { actions } from '../../actions';
import { suggestColor } from '../../panels/colors';
import { state } from '../../state';
import { INK, type Ui } from '../ui';
import type { AskName } from './letters';
import { drawNames } from './names';

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
    void actions.createLabel(name, color, category);
    actions.setTool('paint');
    back();
  };
  ui.text('What is it?', x + em * 0.4, top + em * 0.8, { color: INK.quiet });
  drawNames(ui, [x, top + em * 1.9, inner], 5, color, make);
  const y = top + em * 14.4;
  const h = em * 2.1;
  ui.button(x, y, inner / 3, h, { text: 'Back', icon: 'previous' }, back);
  const type = { text: 'Type a name', icon: 'pencil', strong: true } as const;
  ui.button(x + inner / 2, y, inner / 2 - em * 0.25, h, type, () => {
    ask('Name of the new label', (name) => make(name, ''));
  });
}
