/** A controller held in the hand: an analog trigger, buttons and a stick or pad. */
import { deviceFor } from '../devices';
import { controllerModel, disposeModel } from '../model';
import { buttonValue, type Kind } from './kind';

export const controller: Kind = {
  name: 'controller',
  is: (source) => source.targetRayMode === 'tracked-pointer' && !source.hand,
  reach: 'near',
  momentary: false,
  holds: true,
  drawn: true,
  fleeting: false,
  device: ({ profiles, gamepad }) => deviceFor(profiles, gamepad?.axes.length ?? 0, false),
  // One without a gamepad says only that it selects.
  press: (gamepad, device, selecting) =>
    gamepad ? buttonValue(gamepad, device.trigger) : selecting ? 1 : 0,
  model: (_source, device) => {
    const object = controllerModel(device);
    return { object, gripped: true, dispose: () => disposeModel(object) };
  },
};
