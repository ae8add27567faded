/** The kinds of input that are known; of one side an earlier row comes first. */
import { controller } from './controller';
import { gaze } from './gaze';
import { hand } from './hand';
import type { Kind } from './kind';
import { screen } from './screen';
import { transient } from './transient';

/** A pinch that comes is meant, whatever else that hand is; a controller is more exact than a hand. */
export const KINDS: readonly Kind[] = [transient, controller, hand, gaze, screen];

/** The kind of an input source, or undefined. */
export function kindOf(source: XRInputSource): Kind | undefined {
  return KINDS.find((kind) => kind.is(source));
}

/** Notice about an input that no kind is for. */
export function unknownInput({ targetRayMode, profiles }: XRInputSource): string {
  const named = profiles[0] ? ` (${profiles[0]})` : '';
  return `This kind of input is not known here:\n${targetRayMode}${named}`;
}
