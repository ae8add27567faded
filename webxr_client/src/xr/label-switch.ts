/** The palette hand's pad walks through the labels. */
import { Vector3 } from 'three';
import { actions } from '../actions';
import type { Label } from '../protocol/messages';
import { peek } from '../peek';
import { state } from '../state';
import { LEVEL_TICK } from './haptics';
import type { Pointer } from './pointer';
import type { Rig } from './rig';
import { xrSettings } from './settings';

/** One looks at the palette when its middle is within this angle of straight ahead: 20°. */
const LOOKING = Math.cos((20 * Math.PI) / 180);

/**
 * The part of a pad's lean that is for labels, and the rest of it is for walking: all of it while one
 * looks at the palette, else only down, which no teleport needs.
 */
export function labelLean(y: number, looking: boolean, glides: boolean): number {
  return looking || (y < 0 && !glides) ? y : 0;
}

/** The label so many steps below the active one in the palette, round and round. */
export function labelBeside(palette: readonly Label[], active: number, steps: number): number {
  const at = palette.findIndex(({ id }) => id === active);
  const from = at < 0 && steps < 0 ? 0 : at;
  return palette[(from + steps + palette.length) % palette.length]?.id ?? active;
}

export class LabelSwitch {
  private readonly ahead = new Vector3();
  private readonly way = new Vector3();

  /** Once per picture, before the pad walks; true when another label was chosen. */
  update(hand: Pointer, rig: Rig, palette: Vector3 | null, now: number): boolean {
    const glides = peek(xrSettings).move === 'smooth' && hand.device.pad === 'stick';
    const looking = palette !== null && this.looksAt(rig, palette);
    const lean = labelLean(hand.pad.y, looking, glides);
    const step = -hand.repeatY.update(lean, now);
    if (lean !== 0) hand.pad.y = 0;
    if (step === 0) return false;
    const active = peek(state.activeLabel);
    const next = labelBeside(peek(state.palette), active, step);
    if (next === active) return false;
    actions.selectLabel(next);
    hand.pulse(LEVEL_TICK.strength, LEVEL_TICK.milliseconds);
    return true;
  }

  private looksAt(rig: Rig, place: Vector3): boolean {
    this.ahead.set(0, 0, -1).applyQuaternion(rig.turned);
    this.way.copy(place).sub(rig.head).normalize();
    return this.ahead.dot(this.way) > LOOKING;
  }
}
