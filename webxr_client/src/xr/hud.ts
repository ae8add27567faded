/** What must be said at once, before the eyes: connection, controllers, messages, refusals. */
import { effect } from '@preact/signals';
import { Group, Vector3 } from 'three';
import { plural } from '../panels/format';
import { state } from '../state';
import type { Rig } from './rig';
import { Sign } from './sign';
import { SIZES } from './sizes';

const AWAY = 1;
const STAY_MS = 4000;

export class Hud {
  readonly group = new Group();
  private readonly sign = new Sign({ em: SIZES.message.em, order: 130 });
  private readonly unfollow: () => void;
  private own = '';
  private ownUntil = 0;
  private text = '';
  private readonly goal = new Vector3();

  constructor() {
    this.group.add(this.sign.mesh);
    this.unfollow = effect(() => {
      this.text = standing() || (state.notices.value.at(-1)?.title ?? '');
    });
  }

  /** A message of the headset's own. */
  say(text: string): void {
    this.own = text;
    this.ownUntil = performance.now() + STAY_MS;
  }

  update(rig: Rig, seconds: number, now: number): void {
    this.sign.write(this.text || (now < this.ownUntil ? this.own : ''));
    if (!this.sign.mesh.visible) return;
    const { group } = this;
    // In the rig's own space, so that it comes along when one teleports.
    this.goal.copy(rig.head).addScaledVector(rig.ahead, AWAY);
    this.goal.y -= 0.22;
    rig.group.worldToLocal(this.goal);
    const far = group.position.distanceTo(this.goal) > 1.5;
    group.position.lerp(this.goal, far ? 1 : Math.min(1, seconds * 4));
    group.lookAt(rig.head);
  }

  dispose(): void {
    this.unfollow();
    this.sign.dispose();
    this.group.removeFromParent();
  }
}

/** What stays true until it is over. */
function standing(): string {
  const { state: connection } = state.connection.value;
  const pending = state.pending.value;
  if (connection === 'refused') return 'The server refused this page';
  if (connection === 'offline') {
    const waiting = pending > 0 ? `\n${plural(pending, 'stroke')} waiting` : '';
    return `The server is away: go on painting${waiting}`;
  }
  if (!state.sequence.value) return 'No recording is open';
  return '';
}
