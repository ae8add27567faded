/** The head aims, and a button or a word selects. */
import { SELECTS, type Kind } from './kind';

export const gaze: Kind = {
  ...SELECTS,
  name: 'gaze',
  is: (source) => source.targetRayMode === 'gaze',
  momentary: false,
};
