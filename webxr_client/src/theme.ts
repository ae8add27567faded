/** Light or dark: chosen here, else as the system is; kept for the next visit. */
import { computed, signal, type ReadonlySignal } from '@preact/signals';
import { follow } from './watch';

export type Theme = 'light' | 'dark';

const KEY = 'pointbrush.theme';

/** What was chosen; null: as the system is. */
export const chosenTheme = signal<Theme | null>(kept());
const system = signal<Theme>('dark');

export const theme: ReadonlySignal<Theme> = computed(() => chosenTheme.value ?? system.value);

function kept(): Theme | null {
  try {
    const value = localStorage.getItem(KEY);
    return value === 'light' || value === 'dark' ? value : null;
  } catch {
    return null; // a browser that keeps nothing
  }
}

export function chooseTheme(wanted: Theme): void {
  chosenTheme.value = wanted;
  try {
    localStorage.setItem(KEY, wanted);
  } catch {
    // The choice holds for this visit.
  }
}

/** Put the theme on the page, now and whenever it changes. */
export function installTheme(): void {
  const light = matchMedia('(prefers-color-scheme: light)');
  const hear = (): void => {
    system.value = light.matches ? 'light' : 'dark';
  };
  hear();
  light.addEventListener('change', hear);
  follow(() => {
    document.documentElement.dataset['theme'] = theme.value;
    const meta = document.querySelector<HTMLMetaElement>('meta[name="color-scheme"]');
    if (meta) meta.content = theme.value;
  });
}
