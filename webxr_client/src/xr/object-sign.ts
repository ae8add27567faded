/** At the tip: which level of an object is shown, how large it is, what comes next. */
import { Group, Vector3 } from 'three';
import { shortCount } from '../panels/format';
import { state } from '../state';
import { faceEyes } from './facing';
import type { Rig } from './rig';
import { Sign } from './sign';
import { SIZES } from './sizes';
import { follow } from '../watch';

const BESIDE = { right: 0.02, up: 0.09, away: SIZES.tips.away };

export class ObjectSign {
  readonly group = new Group();
  private readonly sign = new Sign({ em: SIZES.tips.em, order: 125 });
  private readonly at = new Vector3();
  private text = '';
  private readonly unfollow: () => void;

  constructor() {
    this.group.add(this.sign.mesh);
    this.unfollow = follow(() => void (this.text = objectText()));
  }

  /** `tip` in the scene; hidden while the hand has nothing to show. */
  update(rig: Rig, tip: Vector3, visible: boolean): void {
    this.sign.write(visible ? this.text : '');
    if (!this.sign.mesh.visible) return;
    rig.group.worldToLocal(this.at.copy(tip));
    faceEyes(this.group, this.at, rig.headInRig, BESIDE);
  }

  dispose(): void {
    this.unfollow();
    this.sign.dispose();
    this.group.removeFromParent();
  }
}

/** Text of what is offered, in at most three lines; empty when there is nothing. */
export function objectText(): string {
  const view = state.object.value;
  if (!view) return '';
  const lines = [];
  if (view.levels > 0) {
    lines.push(`${view.level + 1} of ${view.levels} · ${shortCount(view.points)} points`);
  }
  if (view.completes) lines.push('Stick pressed, or Complete: object');
  else if (view.taken) lines.push('Trigger adds, eraser removes');
  if (!view.ready) lines.push('Preparing this frame …');
  return lines.join('\n');
}
