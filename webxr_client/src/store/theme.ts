/** Light or dark: dark, on which points are legible, unless chosen; kept for the next visit. */
import { signal } from '@preact/signals';
import { keep, kept } from './kept';
import { follow } from './watch';

export type Theme = 'light' | 'dark';

const KEY = 'pointbrush.theme';

export const theme = signal<Theme>(kept(KEY) === 'light' ? 'light' : 'dark');

export function chooseTheme(wanted: Theme): void {
  theme.value = wanted;
  keep(KEY, wanted);
}

/** Put the theme on the page, now and whenever it changes. */
export function installTheme(): void {
  follow(() => {
    document.documentElement.dataset['theme'] = theme.value;
    const meta = document.querySelector<HTMLMetaElement>('meta[name="color-scheme"]');
    if (meta) meta.content = theme.value;
  });
}
