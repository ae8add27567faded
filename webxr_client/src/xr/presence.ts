/** Tells the others where one is, a few times a second.  The message is made once and sent again. */
import { Matrix4, Quaternion, Vector3, type Object3D } from 'three';
import type { Afterwards } from '../cloud/afterwards';
import type { Link } from '../net/link';
import type { ClientPresence } from '../protocol/messages';
import { state } from '../state';
import type { Hand } from './hand';
import type { Rig } from './rig';

const PERIOD_MS = 100;

type Pose = [number, number, number, number, number, number, number];
type Message = Required<ClientPresence>;

const nowhere = (): Pose => [0, 0, 0, 0, 0, 0, 1];

export class Presence {
  private last = 0;
  private readonly roomFromScene = new Matrix4();
  private readonly turnFromScene = new Quaternion();
  private readonly at = new Vector3();
  private readonly way = new Quaternion();
  private readonly head = nowhere();
  private readonly hands: readonly [Pose, Pose] = [nowhere(), nowhere()];
  private readonly brush: [number, number, number] = [0, 0, 0];
  private readonly message: Message = {
    type: 'presence',
    frame: 0,
    label: 0,
    head: this.head,
    hands: [null, null],
    brush: this.brush,
    radius: 0,
  };

  /** The message says something new. */
  private due = false;

  constructor(
    private readonly link: Link,
    private readonly afterwards: Afterwards,
  ) {
    afterwards.runs.push(this.tell);
  }

  update(now: number, rig: Rig, hands: readonly Hand[], tip: Vector3, world: Object3D): void {
    if (now - this.last < PERIOD_MS || state.sequence.peek() === null) return;
    this.last = now;
    this.roomFromScene.copy(world.matrixWorld).invert();
    world.getWorldQuaternion(this.turnFromScene).invert();
    const { message } = this;
    this.write(this.head, rig.head, rig.turned);
    for (let i = 0; i < 2; i++) {
      const hand = hands[i]!;
      const pose = this.hands[i as 0 | 1];
      if (hand.tracked) this.write(pose, hand.place, hand.turn);
      message.hands[i] = hand.tracked ? pose : null;
    }
    this.at.copy(tip).applyMatrix4(this.roomFromScene).toArray(this.brush);
    message.radius = state.brush.peek().radius;
    this.due = true;
    this.afterwards.ask();
  }

  private readonly tell = (): void => {
    if (!this.due) return;
    this.due = false;
    this.send(this.message);
  };

  private write(pose: Pose, place: Vector3, turn: Quaternion): void {
    this.at.copy(place).applyMatrix4(this.roomFromScene).toArray(pose);
    this.way.copy(turn).premultiply(this.turnFromScene).toArray(pose, 3);
  }

  /** One has left the room. */
  gone(): void {
    const { runs } = this.afterwards;
    runs.splice(runs.indexOf(this.tell), 1);
    this.send({ ...this.message, head: null, hands: [], brush: null, radius: 0 });
  }

  private send(message: Message): void {
    message.frame = state.frame.peek();
    message.label = state.activeLabel.peek();
    this.link.send(message);
  }
}
