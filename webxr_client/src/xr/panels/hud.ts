/** Urgent notices before the eyes: connection, controllers, messages, refusals. */
import { Group, Vector3 } from 'three';
import { plural } from '../../common/format';
import { DOUBT_PREFIX } from '../../engine/review';
import { state } from '../../store/state';
import { faceEyes } from '../drawing/facing';
import type { Rig } from '../moving/rig';
import { Sign } from '../drawing/sign';
import { SIZES } from '../drawing/sizes';
import { noticeText } from './notice-text';
import { follow } from '../../store/watch';

/** Metres ahead and below the eyes, and metres from this place beyond which it jumps there. */
const AHEAD = 1;
const BELOW = 0.22;
const FAR = 1.5;
const FACING = { right: 0, up: 0, distance: SIZES.message.distance };
const STAY_MS = 4000;
/** Time to read a letter beyond the first line, milliseconds. */
const READ_MS = 40;

export class Hud {
  readonly group = new Group();
  private readonly sign = new Sign({ em: SIZES.message.em, order: 130 });
  private readonly unsubscribe: () => void;
  private own = '';
  private ownUntil = 0;
  /** A lasting notice, which comes first. */
  private text = '';
  private readonly goal = new Vector3();
  private readonly at = new Vector3();

  constructor() {
    this.group.add(this.sign.mesh);
    const stops = [
      follow(() => void (this.text = standing())),
      follow(() => {
        const notice = state.notices.value.at(-1);
        // The question beside the object says it.
        if (notice && !notice.title.startsWith(DOUBT_PREFIX)) this.showMessage(noticeText(notice));
      }),
    ];
    this.unsubscribe = () => {
      for (const stop of stops) stop();
    };
  }

  /** Show a message for a while, because it cannot be dismissed here. */
  showMessage(text: string): void {
    this.own = text;
    const [first = ''] = text.split('\n');
    this.ownUntil = performance.now() + STAY_MS + READ_MS * (text.length - first.length);
  }

  update(rig: Rig, seconds: Float64Array, now: number): void {
    this.sign.write(this.text || (now < this.ownUntil ? this.own : ''));
    if (!this.sign.mesh.visible) return;
    const { at, goal } = this;
    // In the rig's own space, so that it comes along when one teleports.
    goal.copy(rig.head).addScaledVector(rig.ahead, AHEAD);
    goal.y -= BELOW;
    rig.group.worldToLocal(goal);
    const far = at.distanceToSquared(goal) > FAR * FAR;
    at.lerp(goal, far ? 1 : Math.min(1, seconds[0]! * 4));
    faceEyes(this.group, at, rig.headInRig, FACING);
  }

  dispose(): void {
    this.unsubscribe();
    this.sign.dispose();
    this.group.removeFromParent();
  }
}

/** Return the notice that holds until it is over. */
function standing(): string {
  const { state: connection } = state.connection.value;
  const pending = state.pending.value;
  if (connection === 'refused') return 'The server refused this page';
  if (connection === 'offline') {
    const waiting = pending > 0 ? `\n${plural(pending, 'stroke')} waiting` : '';
    return `The server does not answer: continue to paint${waiting}`;
  }
  if (!state.sequence.value) return 'No recording is open';
  return '';
}
