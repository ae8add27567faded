/** The box of the box tool, until Enter takes what is in it. */
import { signal } from '@preact/signals';
import type { Volume } from '../volume/volume';

export const boxDraft = signal<Volume | null>(null);
