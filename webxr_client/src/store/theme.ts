/** Light or dark: dark, on which points are legible, unless chosen; kept for the next visit. */
import { signal } from '@preact/signals';
import { follow } from './watch';

export type Theme = 'light' | 'dark';

const KEY = 'pointbrush.theme';

export const theme = signal<Theme>(kept() ?? 'dark');

function kept(): Theme | null {
  try {
    const value = localStorage.getItem(KEY);
    return value === 'light' || value === 'dark' ? value : null;
  } catch {
    return null; // a browser that keeps nothing
  }
}

export function chooseTheme(wanted: Theme): void {
  theme.value = wanted;
  try {
    localStorage.setItem(KEY, wanted);
  } catch {
    // The choice holds for this visit.
  }
}

/** Put the theme on the page, now and whenever it changes. */
export function installTheme(): void {
  follow(() => {
    document.documentElement.dataset['theme'] = theme.value;
    const meta = document.querySelector<HTMLMetaElement>('meta[name="color-scheme"]');
    if (meta) meta.content = theme.value;
  });
}
