/** How the desk looks at the recording. */
import { signal } from '@preact/signals';

/** The picture is orthographic; the engine writes it. */
export const orthographic = signal(false);
