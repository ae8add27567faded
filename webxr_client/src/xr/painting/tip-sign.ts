/** Text at the brush: the label that was chosen just now, or the level of an object. */
import { untracked } from '@preact/signals';
import { Group, Vector3 } from 'three';
import { shortCount } from '../../common/format';
import { acceptPeople, peopleOffer } from '../../engine/find-people';
import type { Device } from '../input/devices';
import { padName } from '../input/lessons';
import type { Pointer } from '../input/pointer';
import { activeLabel, state } from '../../store/state';
import { faceEyes } from '../drawing/facing';
import type { Rig } from '../moving/rig';
import { Sign } from '../drawing/sign';
import { SIZES } from '../drawing/sizes';
import { follow } from '../../store/watch';
import type { Painter } from './painter';
import { preparation } from '../../tools/preparation';
import { roomWay } from '../../tools/ways';

/** Milliseconds for which a new label's name is shown. */
const LABEL_MS = 1500;
const BESIDE = { right: 0.02, up: 0.09, distance: SIZES.tips.distance };

export class TipSign {
  readonly group = new Group();
  private readonly sign = new Sign({ em: SIZES.tips.em, order: 125 });
  private readonly at = new Vector3();
  private text = '';
  /** The sign's text is for this device, and for a trigger that is held or not. */
  private device: Device | null = null;
  private held = false;
  private label = '';
  private labelUntil = 0;
  private readonly unsubscribers: (() => void)[];

  /** `changed`: another label is active from now on. */
  constructor(changed: () => void) {
    this.group.add(this.sign.mesh);
    let before = state.activeLabel.peek();
    this.unsubscribers = [
      follow(() => void (this.text = objectText(this.device, this.held))),
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

  /** Hidden while the hand is out of sight. */
  update(rig: Rig, hand: Pointer | null, { tip, painting }: Painter, now: number): void {
    if (hand && (hand.device !== this.device || painting !== this.held)) {
      this.device = hand.device;
      this.held = painting;
      this.text = untracked(() => objectText(this.device, this.held));
    }
    const text = now < this.labelUntil ? this.label : this.text;
    this.sign.write(hand?.tracked === true ? text : '');
    if (!this.sign.mesh.visible) return;
    rig.group.worldToLocal(this.at.copy(tip));
    faceEyes(this.group, this.at, rig.headInRig, BESIDE);
  }

  dispose(): void {
    for (const stop of this.unsubscribers) stop();
    this.sign.dispose();
    this.group.removeFromParent();
  }
}

/** Text of an offered object and of the control that takes it, in at most three lines; empty when there is nothing. */
export function objectText(device: Device | null, held: boolean): string {
  const people = peopleOffer.value;
  if (people)
    return people.main?.run === acceptPeople ? `${people.text}\nTrigger: accept` : people.text;
  const view = state.object.value;
  const clicks = roomWay().samples === 'clicks';
  if (!view) return clicks ? (preparation() ?? '') : '';
  const shown = `${view.level + 1} of ${view.levels} · ${shortCount(view.points)} points`;
  return [
    view.levels > 0 ? shown : '',
    view.completes || (view.taken && clicks) ? controlText(view.taken, device, held) : '',
    view.ready ? '' : 'Preparing this frame …',
  ]
    .filter((line) => line !== '')
    .join('\n');
}

function controlText(taken: boolean, device: Device | null, held: boolean): string {
  const pad = device && device.pad !== 'none' ? padName(device) : null;
  if (pad && held) return taken ? `${pad} ↑ ↓: level` : `${pad} ↑ ↓: level, let go: object`;
  if (taken) return 'Trigger adds, eraser removes';
  return pad ? `Hold Trigger, ${pad} ↑: object` : 'Palette, Tools: object';
}
