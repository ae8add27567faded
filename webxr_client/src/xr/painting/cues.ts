/** Cues of the hand that paints: a pulse, and where none can be felt a sound and a glow of the brush. */
import { peek } from '../../store/watch';
import type { Painter } from './painter';
import type { Pointer } from '../input/pointer';
import type { Rig } from '../moving/rig';
import { xrSettings } from '../../store/xr-settings';
import { Sounds } from './sounds';

export class Cues {
  private readonly sounds = new Sounds();

  constructor(private readonly rig: Rig) {}

  /** Give a cue of a strength, 0..1, to the hand that paints with `painter`. */
  give(hand: Pointer | null, painter: Painter, strength: number, milliseconds: number): void {
    if (!hand) return;
    const hasPulsed = hand.pulse(strength, milliseconds);
    const { sound } = peek(xrSettings);
    if (hasPulsed && sound !== 'always') return;
    painter.glow();
    if (sound !== 'off') this.sounds.play(strength, milliseconds, painter.tip, this.rig);
  }

  /** A gesture of the person, which lets a browser that suspended its sound go on. */
  readonly wake = (): void => this.sounds.wake();

  dispose(): void {
    this.sounds.dispose();
  }
}
