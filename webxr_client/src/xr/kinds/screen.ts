/** A finger on the screen of a phone that one holds up. */
import { SELECTS, type Kind } from './kind';

export const screen: Kind = {
  ...SELECTS,
  name: 'touch',
  is: (source) => source.targetRayMode === 'screen',
  momentary: true,
};
