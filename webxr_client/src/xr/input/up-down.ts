/** Up and down of the thumb of the hand that paints: the ring of labels, or levels of an object. */
import type { Label } from '../../protocol/messages';
import { actions } from '../../store/actions';
import { state } from '../../store/state';
import { peek } from '../../store/watch';
import { Repeat } from './pad';
import type { Pointer } from './pointer';

/** Purpose of a push, from its beginning until the thumb lets go; `over`: it does nothing more. */
type Purpose = 'none' | 'labels' | 'levels' | 'over';

export interface UpDownActs {
  /** Another label is marked on the ring. */
  marked(): void;
  taken(hand: Pointer): void;
  /** A push up (1) or down (−1) while the trigger is held. */
  level(step: number): void;
}

/**
 * A push is for labels while the trigger is up and for the levels of an object while it is held.  A
 * stick marks a label while it leans and takes it when it is let go; a touchpad marks it when it is
 * touched and takes it when it is pressed.
 */
export class UpDown {
  /** The thumb is at the ring. */
  shown = false;
  /** Steps down the palette from the active label to the marked one; 0: none is marked. */
  marked = 0;
  private purpose: Purpose = 'none';
  private hand: Pointer | null = null;
  private readonly repeat = new Repeat();

  constructor(private readonly acts: UpDownActs) {}

  /** Once per picture, before the pad does anything else. */
  update(hand: Pointer | null, now: number): void {
    const same = hand !== null && hand === this.hand;
    this.hand = hand;
    if (same && hand.tracked && !hand.squeeze.down) this.follow(hand, now);
    else this.forget();
  }

  private follow(hand: Pointer, now: number): void {
    const { pad, pinching } = hand;
    this.shown = pad.touched || pad.y !== 0;
    if (pad.y === 0) this.letGo();
    else if (this.purpose === 'none') this.purpose = pinching ? 'levels' : 'labels';
    this.obeyTrigger(pinching);
    const idle = this.purpose === 'none' || this.purpose === 'over';
    const step = this.repeat.update(idle ? 0 : pad.y, now);
    if (this.purpose === 'levels' && step !== 0) this.acts.level(step);
    if (this.purpose === 'labels') this.push(hand, step);
    else this.mark(this.purpose === 'none' && !pinching ? -pad.over : 0);
  }

  private push({ device, pad }: Pointer, step: number): void {
    if (step === 0) return;
    if (device.pad !== 'touchpad') {
      this.mark(this.marked - step);
      return;
    }
    this.marked = -step;
    this.take();
    // Held on, the press takes the next one.
    this.mark(-Math.sign(pad.y));
  }

  private mark(steps: number): void {
    const marked = peek(state.palette).length < 2 ? 0 : steps;
    if (marked === this.marked) return;
    this.marked = marked;
    if (marked !== 0) this.acts.marked();
  }

  /** The label that was marked is the stroke's; a level that is shown is the press's alone. */
  private obeyTrigger(pinching: boolean): void {
    const { purpose } = this;
    if (purpose === 'labels' && pinching && this.marked !== 0 && !this.presses) this.take();
    if (purpose === (pinching ? 'labels' : 'levels')) this.purpose = 'over';
  }

  private letGo(): void {
    if (this.purpose === 'labels' && !this.presses) this.take();
    this.purpose = 'none';
  }

  /** Whether a label is taken by a press and not by letting go. */
  private get presses(): boolean {
    return this.hand?.device.pad === 'touchpad';
  }

  private take(): void {
    const active = peek(state.activeLabel);
    const next = labelBeside(peek(state.palette), active, this.marked);
    this.marked = 0;
    if (next === active) return;
    actions.labels.selectLabel(next);
    this.acts.taken(this.hand!);
  }

  /** Another hand paints, this one is out of sight, or the pad is its grip's: nothing is taken. */
  private forget(): void {
    this.purpose = 'over';
    this.shown = false;
    this.marked = 0;
    this.repeat.update(0, 0);
  }
}

/** The label so many steps below the active one in the palette, round and round. */
export function labelBeside(palette: readonly Label[], active: number, steps: number): number {
  const { length } = palette;
  const at = palette.findIndex(({ id }) => id === active);
  const from = at < 0 && steps < 0 ? 0 : at;
  return palette[(((from + steps) % length) + length) % length]?.id ?? active;
}
