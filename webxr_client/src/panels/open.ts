/** Popovers that more than one place opens. */
import { signal } from '@preact/signals';

export const helpOpen = signal(false);
export const commandsOpen = signal(false);
export const exportOpen = signal(false);
export const historyOpen = signal(false);
