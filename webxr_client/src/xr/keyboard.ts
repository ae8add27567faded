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
