/** The headset: sessions on request, and the others in the room. */
import type { Engine } from '../engine/engine';
import type { Overlays } from '../overlays/index';
export { leadFirstMinute } from './first-minute';
import { followPeople, People } from './bodies/people';
import { Headset } from './headset';
import { installHeadsetHook } from './hook';

/** Wire the headset to the engine. */
export function installHeadset(engine: Engine, overlays: Overlays): Headset {
  const headset = new Headset(engine);
  const { viewer } = engine;
  followPeople(engine);
  const people = new People(viewer.world, () => viewer.invalidate());
  installHeadsetHook(engine, headset, overlays, people);
  viewer.ticks.add(() => people.face(headset.cockpit?.rig.head ?? viewer.camera.position));
  return headset;
}
