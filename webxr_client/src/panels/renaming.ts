import { signal } from '@preact/signals';

/** The label whose name is being typed. */
export const renaming = signal<number | null>(null);
