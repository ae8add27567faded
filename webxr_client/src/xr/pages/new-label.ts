/** A new label: quick names, each with a colour unlike the others, or one that is typed. */
import { actions } from '../../actions';
import { suggestColor, suggestName } from '../../panels/colors';
import { state } from '../../state';
import type { SystemKeyboard } from '../keyboard';
import { INK, type Ui } from '../ui';

const QUICK = ['pin', 'hand', 'person', 'ball', 'head', 'object', 'vehicle', 'table'];
const MOST = 10;

export function drawNew(
  ui: Ui,
  x: number,
  top: number,
  inner: number,
  keyboard: SystemKeyboard,
  back: () => void,
): void {
  const { em } = ui;
  const palette = state.palette.peek();
  const names = palette.map((label) => label.name);
  const color = suggestColor(palette.map((label) => label.color));
  // Names without a keyboard: categories in use, then common ones; each counts on.
  const used = palette.map((label) => label.category).filter(Boolean);
  const choices = [...new Set([...used, ...QUICK])].slice(0, MOST);
  const make = (name: string, category: string): void => {
    void actions.createLabel(name, color, category);
    actions.setTool('paint');
    back();
  };
  ui.text('What is it?', x + em * 0.4, top + em * 0.8, { color: INK.quiet });
  choices.forEach((category, i) => {
    const name = suggestName(category, names);
    const [column, line] = [i % 2, Math.floor(i / 2)];
    const w = inner / 2;
    ui.button(x + column * w, top + em * (1.9 + 2.4 * line), w - em * 0.25, em * 2.2,
      { swatch: color, text: name, strong: true, align: 'left' },
      () => make(name, category));
  }); // prettier-ignore
  const y = top + em * 14.4;
  const h = em * 2.1;
  ui.button(x, y, inner / 3, h, { text: 'Back', icon: 'previous' }, back);
  if (!keyboard.supported) return;
  const type = { text: 'Type a name', icon: 'pencil', strong: true } as const;
  ui.button(x + inner / 2, y, inner / 2 - em * 0.25, h, type, () => {
    keyboard.ask('Name of the new label', (name) => make(name, ''));
  });
}
