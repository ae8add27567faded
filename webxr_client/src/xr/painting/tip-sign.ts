/** Text at the brush: the label that was chosen just now, or the level of an object. */
import { Group, Vector3 } from 'three';
import { shortCount } from '../../common/format';
import { activeLabel, state } from '../../store/state';
import { faceEyes } from '../drawing/facing';
import type { Rig } from '../moving/rig';
import { Sign } from '../drawing/sign';
import { SIZES } from '../drawing/sizes';
import { follow } from '../../store/watch';
import { preparation } from '../../tools/preparation';
import { roomWay } from '../../tools/ways';

/** Milliseconds for which a new label's name is shown. */
const LABEL_MS = 1500;
const BESIDE = { right: 0.02, up: 0.09, away: SIZES.tips.away };

export class TipSign {
  readonly group = new Group();
  private readonly sign = new Sign({ em: SIZES.tips.em, order: 125 });
  private readonly at = new Vector3();
  private text = '';
  private label = '';
  private labelUntil = 0;
  private readonly unfollow: (() => void)[];

  /** `changed`: another label is active from now on. */
  constructor(changed: () => void) {
    this.group.add(this.sign.mesh);
    let before = state.activeLabel.peek();
    this.unfollow = [
      follow(() => void (this.text = objectText())),
      follow(() => {
        const now = state.activeLabel.value;
        if (now === before) return;
        before = now;
        this.label = activeLabel.peek()?.name ?? '';
        this.labelUntil = performance.now() + LABEL_MS;
        changed();
      }),
    ];
  }

  /** `tip` in the scene; hidden while the hand has nothing to show. */
  update(rig: Rig, tip: Vector3, visible: boolean, now: number): void {
    const text = now < this.labelUntil ? this.label : this.text;
    this.sign.write(visible ? text : '');
    if (!this.sign.mesh.visible) return;
    rig.group.worldToLocal(this.at.copy(tip));
    faceEyes(this.group, this.at, rig.headInRig, BESIDE);
  }

  dispose(): void {
    for (const stop of this.unfollow) stop();
    this.sign.dispose();
    this.group.removeFromParent();
  }
}

/** Text of what is offered, in at most three lines; empty when there is nothing. */
export function objectText(): string {
  const view = state.object.value;
  if (!view) return roomWay().samples === 'clicks' ? (preparation() ?? '') : '';
  const lines = [];
  if (view.levels > 0) {
    lines.push(`${view.level + 1} of ${view.levels} · ${shortCount(view.points)} points`);
  }
  if (view.completes) lines.push('Stick pressed, or Complete: object');
  else if (view.taken) lines.push('Trigger adds, eraser removes');
  if (!view.ready) lines.push('Preparing this frame …');
  return lines.join('\n');
}
