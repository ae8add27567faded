/** Names that need no keyboard: categories in use, then common ones; each counts on. */
import { suggestName } from '../../panels/colors';
import { state } from '../../state';
import type { Ui } from '../ui';

const QUICK = ['pin', 'hand', 'person', 'ball', 'head', 'object', 'vehicle', 'table'];
/** Ems from one line of names to the next. */
const PITCH = 2.4;

export type TakeName = (name: string, category: string) => void;

/** Lay out names in so many lines of two, each with the colour that it is for. */
export function drawNames(
  ui: Ui,
  [x, y, inner]: readonly [x: number, y: number, inner: number],
  lines: number,
  color: string,
  take: TakeName,
): void {
  const { em } = ui;
  const palette = state.palette.peek();
  const names = palette.map((label) => label.name);
  const used = palette.map((label) => label.category).filter(Boolean);
  const choices = [...new Set([...used, ...QUICK])].slice(0, 2 * lines);
  const w = inner / 2;
  choices.forEach((category, i) => {
    const name = suggestName(category, names);
    const [left, top] = [x + (i % 2) * w, y + em * PITCH * Math.floor(i / 2)];
    const look = { swatch: color, text: name, strong: true, align: 'left' } as const;
    ui.button(left, top, w - em * 0.25, em * 2.2, look, () => take(name, category));
  });
}
