/** Tells the others where one is, a few times a second. */
import { Matrix4, Quaternion, Vector3 } from 'three';
import type { Link } from '../net/link';
import type { ClientPresence } from '../protocol/messages';
import { state } from '../state';
import type { Hand } from './hand';
import type { Rig } from './rig';

const PERIOD_MS = 100;

export class Presence {
  private last = 0;
  private readonly roomFromScene = new Matrix4();
  private readonly at = new Vector3();
  private readonly way = new Quaternion();

  constructor(private readonly link: Link) {}

  update(
    now: number,
    rig: Rig,
    hands: readonly Hand[],
    tip: Vector3,
    headTurn: Quaternion,
    world: Matrix4,
  ): void {
    if (now - this.last < PERIOD_MS || state.sequence.peek() === null) return;
    this.last = now;
    this.roomFromScene.copy(world).invert();
    this.send({
      head: this.pose(rig.head, headTurn),
      hands: hands.map((hand) => (hand.tracked ? this.pose(hand.place, hand.turn) : null)),
      brush: this.at.copy(tip).applyMatrix4(this.roomFromScene).toArray(),
      radius: state.brush.peek().radius,
    });
  }

  private pose(
    place: Vector3,
    turn: Quaternion,
  ): [number, number, number, number, number, number, number] {
    const { x, y, z } = this.at.copy(place).applyMatrix4(this.roomFromScene);
    this.way.setFromRotationMatrix(ROTATION.extractRotation(this.roomFromScene)).multiply(turn);
    return [x, y, z, this.way.x, this.way.y, this.way.z, this.way.w];
  }

  /** One has left the room. */
  gone(): void {
    this.send({ head: null, hands: [], brush: null, radius: 0 });
  }

  private send(where: Pick<ClientPresence, 'head' | 'hands' | 'brush' | 'radius'>): void {
    this.link.send({
      type: 'presence',
      frame: state.frame.peek(),
      label: state.activeLabel.peek(),
      ...where,
    });
  }
}

const ROTATION = new Matrix4();
