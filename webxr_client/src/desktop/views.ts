/** Views of the recording at the desk. */
import { signal } from '@preact/signals';

/** The picture is orthographic; the engine writes it. */
export const orthographic = signal(false);
