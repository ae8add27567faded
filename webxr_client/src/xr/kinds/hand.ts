/** A bare hand: a pinch presses, a fingertip pokes panels. */
import { deviceFor } from '../devices';
import { HandModel } from '../hand-model';
import { buttonValue, type Kind } from './kind';

export const hand: Kind = {
  name: 'hand',
  is: (source) => source.targetRayMode === 'tracked-pointer' && Boolean(source.hand),
  reach: 'near',
  momentary: false,
  holds: true,
  drawn: true,
  fleeting: true,
  device: ({ profiles, gamepad }) => deviceFor(profiles, gamepad?.axes.length ?? 0, true),
  press: (gamepad, device, selecting) =>
    Math.max(buttonValue(gamepad, device.trigger), selecting ? 1 : 0),
  model: (source) => new HandModel(source.hand!),
};
