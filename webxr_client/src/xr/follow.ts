/** At the desk: see what somebody in a headset sees. */
import { Quaternion, Vector3 } from 'three';
import type { Engine } from '../engine/engine';
import { following } from '../panels/people';
import { state } from '../state';

const AHEAD = 1.5;

/** Bring the desk's camera to the eyes of the person followed; the result stops it. */
export function followPeople(engine: Engine): () => void {
  const eye = new Vector3();
  const target = new Vector3();
  const turn = new Quaternion();
  return state.people.subscribe((people) => {
    const viewer = following.peek();
    if (viewer === null) return;
    const head = people.find((person) => person.viewer === viewer)?.head;
    if (!head) {
      following.value = null;
      return;
    }
    eye.set(head[0], head[1], head[2]);
    turn.set(head[3], head[4], head[5], head[6]);
    target.set(0, 0, -AHEAD).applyQuaternion(turn).add(eye);
    engine.camera.lookAt(eye, target, true);
    engine.viewer.invalidate();
  });
}
