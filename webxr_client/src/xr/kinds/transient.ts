/** Look and pinch: the eyes aim when a pinch begins, the hand drags from there. */
import { SELECTS, type Kind } from './kind';

export const transient: Kind = {
  ...SELECTS,
  name: 'look and pinch',
  is: (source) => source.targetRayMode === 'transient-pointer',
  momentary: true,
};
