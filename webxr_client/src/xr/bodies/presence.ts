/** Tells the others where one is, a few times a second.  The message is made once and sent again. */
import { Matrix4, Vector3, type Object3D, type Quaternion } from 'three';
import type { Afterwards } from '../../cloud/picture/afterwards';
import type { Link } from '../../net/link';
import type { ClientPresence } from '../../protocol/messages';
import { peek } from '../../store/watch';
import { state } from '../../store/state';
import type { Pointers } from './pointers';
import type { Rig } from '../moving/rig';

const PERIOD_MS = 100;

type Pose = [number, number, number, number, number, number, number];
type Message = Required<ClientPresence>;

const identityPose = (): Pose => [0, 0, 0, 0, 0, 0, 1];

export class Presence {
  private readonly last = new Float64Array(1);
  private readonly roomFromScene = new Matrix4();
  private readonly at = new Vector3();
  private readonly head = identityPose();
  private readonly hands: readonly [Pose, Pose] = [identityPose(), identityPose()];
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

  private readonly stop: () => void;
  /** The message says something new. */
  private due = false;

  constructor(
    private readonly link: Link,
    private readonly afterwards: Afterwards,
  ) {
    this.stop = afterwards.runs.add(this.sendDueMessage);
  }

  update(now: number, rig: Rig, pointers: Pointers, tip: Vector3, world: Object3D): void {
    if (now - this.last[0]! < PERIOD_MS || peek(state.sequence) === null) return;
    this.last[0] = now;
    this.roomFromScene.copy(world.matrixWorld).invert();
    const { message } = this;
    this.write(this.head, rig.head, rig.turned, world.quaternion);
    for (let i = 0; i < 2; i++) {
      const hand = pointers.of(i === 0 ? 'left' : 'right');
      const pose = this.hands[i as 0 | 1];
      if (hand?.tracked) this.write(pose, hand.place, hand.turn, world.quaternion);
      message.hands[i] = hand?.tracked ? pose : null;
    }
    this.place(this.brush, tip);
    message.radius = peek(state.brush).radius;
    this.due = true;
    this.afterwards.ask();
  }

  private readonly sendDueMessage = (): void => {
    if (!this.due) return;
    this.due = false;
    this.send(this.message);
  };

  private place(out: number[], scene: Vector3): void {
    const { at } = this;
    at.copy(scene).applyMatrix4(this.roomFromScene);
    out[0] = at.x;
    out[1] = at.y;
    out[2] = at.z;
  }

  /** `world`: how the recording was turned in the scene, which is taken back. */
  private write(pose: Pose, place: Vector3, turn: Quaternion, world: Quaternion): void {
    this.place(pose, place);
    const { x, y, z, w } = turn;
    const a = -world.x;
    const b = -world.y;
    const c = -world.z;
    const d = world.w;
    pose[3] = d * x + a * w + b * z - c * y;
    pose[4] = d * y + b * w + c * x - a * z;
    pose[5] = d * z + c * w + a * y - b * x;
    pose[6] = d * w - a * x - b * y - c * z;
  }

  /** One has left the room. */
  leave(): void {
    this.stop();
    this.send({ ...this.message, head: null, hands: [], brush: null, radius: 0 });
  }

  private send(message: Message): void {
    message.frame = peek(state.frame);
    message.label = peek(state.activeLabel);
    this.link.send(message);
  }
}
