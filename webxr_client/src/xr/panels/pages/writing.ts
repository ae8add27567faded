/** Writing in the headset: on its own keyboard, or with letters to point at where a browser opens none. */
import { INK, RAISED, type Ui } from '../../drawing/ui';

const ROWS = ['1234567890', 'qwertyuiop', 'asdfghjkl', 'zxcvbnm-_'] as const;
const KEYS = 10;
/** Letters that a name may have. */
const MOST = 64;
/** Ems from one row to the next. */
const PITCH = 2.7;

/** Ask for a name; `take` gets one that is not empty. */
export type AskName = (question: string, take: (name: string) => void) => void;

export class LettersPage {
  private text = '';
  private capitals = false;
  private question = '';
  private take: (name: string) => void = () => undefined;

  constructor(
    private readonly touch: () => void,
    private readonly back: () => void,
  ) {}

  readonly ask: AskName = (question, take) => {
    this.text = '';
    this.capitals = false;
    this.question = question;
    this.take = take;
  };

  draw(ui: Ui, x: number, top: number, inner: number): void {
    const { em } = ui;
    ui.text(this.question, x + em * 0.4, top + em * 0.8, { color: INK.quiet, width: inner });
    ui.box(x, top + em * 1.8, inner - em * 0.2, em * 2.2, RAISED);
    ui.text(`${this.text}_`, x + em * 0.6, top + em * 2.9, { width: inner - em * 1.4 });
    ROWS.forEach((row, i) => this.drawRow(ui, x, top + em * (4.6 + PITCH * i), inner, row));
    this.drawEnd(ui, x, top + em * (4.6 + PITCH * ROWS.length), inner);
  }

  private drawRow(ui: Ui, x: number, y: number, inner: number, row: string): void {
    const { em } = ui;
    const w = inner / KEYS;
    Array.from(row).forEach((key, i) => {
      const text = this.capitals ? key.toUpperCase() : key;
      const left = x + (i + (KEYS - row.length) / 2) * w;
      ui.button(left, y, w - em * 0.2, em * 2.4, { text, strong: true }, () => this.write(text));
    });
  }

  private drawEnd(ui: Ui, x: number, y: number, inner: number): void {
    const { em } = ui;
    const third = inner / 3;
    const [wide, h] = [third - em * 0.2, em * 2.2];
    const key = { strong: true } as const;
    ui.button(x, y, wide, h, { text: 'Capitals', on: this.capitals, ...key }, () => {
      this.capitals = !this.capitals;
      this.touch();
    });
    ui.button(x + third, y, wide, h, { text: 'Space', ...key }, () => this.write(' '));
    ui.button(x + 2 * third, y, wide, h, { text: 'Remove', ...key }, () => {
      this.text = this.text.slice(0, -1);
      this.touch();
    });
    const below = y + em * 2.5;
    ui.button(x, below, wide, h, { text: 'Back', icon: 'previous' }, this.back);
    const name = this.text.trim();
    const done = { text: 'Take', icon: 'check', disabled: name === '', ...key } as const;
    ui.button(x + 2 * third, below, wide, h, done, () => {
      this.back();
      this.take(name);
    });
  }

  private write(letter: string): void {
    this.text = (this.text + letter).slice(0, MOST);
    this.touch();
  }
}

/**
 * The headset's own keyboard: it comes up when something to write in has the focus, and the session
 * goes on behind it (WebXR: `isSystemKeyboardSupported`).
 */
export class SystemKeyboard {
  private field: HTMLInputElement | null = null;

  constructor(private readonly session: XRSession) {}

  get supported(): boolean {
    return this.session.isSystemKeyboardSupported;
  }

  /** Let the person write a line; `take` gets it unless it is empty. */
  ask(name: string, take: (text: string) => void): void {
    this.close();
    const field = document.createElement('input');
    field.type = 'text';
    field.maxLength = 64;
    field.autocomplete = 'off';
    field.setAttribute('aria-label', name);
    // It must be there to take the focus, and need not be seen.
    field.style.cssText = 'position:fixed;top:0;left:0;opacity:0;pointer-events:none';
    const finish = (): void => {
      if (this.field !== field) return;
      this.close();
      const text = field.value.trim();
      if (text) take(text);
    };
    field.addEventListener('blur', finish);
    field.addEventListener('keydown', (event) => {
      // The desk's shortcuts are not meant.
      event.stopPropagation();
      if (event.key === 'Enter') finish();
      if (event.key === 'Escape') this.close();
    });
    this.field = field;
    document.body.append(field);
    field.focus();
  }

  close(): void {
    const { field } = this;
    this.field = null;
    field?.remove();
  }
}
