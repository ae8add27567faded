import type { Ui } from '../../drawing/ui';

/** The reason why everything that changes labels is disabled. */
export const VIEWER = 'Your role cannot change labels.';

/** Rows of a list that are in sight. */
export const ROWS = 7;

/** The part of a list that is in sight, and the buttons that turn it. */
export class Rows {
  first = 0;

  constructor(private readonly touch: () => void) {}

  /** The part of a list that is in sight. */
  of<Entry>(list: readonly Entry[]): Entry[] {
    this.first = Math.min(this.first, Math.max(0, list.length - ROWS));
    return list.slice(this.first, this.first + ROWS);
  }

  /** At the right end of a line that is `inner` wide. */
  drawTurning(ui: Ui, x: number, y: number, inner: number, more: boolean): void {
    const w = inner / 4;
    const place = [w * 0.52, ui.em * 2.2] as const;
    const turn = { disabled: !more };
    const scroll = (by: number) => () => {
      this.first = Math.max(0, this.first + by);
      this.touch();
    };
    ui.button(x + w * 2.9, y, ...place, { icon: 'previous', ...turn }, scroll(-ROWS));
    ui.button(x + w * 3.45, y, ...place, { icon: 'next', ...turn }, scroll(ROWS));
  }
}
