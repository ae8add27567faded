/** Up and down of the thumb of the hand that paints: a ring of labels or answers, or levels of an object. */
import type { Label } from '../../protocol/messages';
import { actions } from '../../store/actions';
import { state } from '../../store/state';
import { peek } from '../../store/watch';
import { Repeat } from './pad';
import type { Pointer } from './pointer';

/** Purpose of a push, from its beginning until the thumb lets go; `over`: it does nothing more. */
type Purpose = 'none' | 'labels' | 'levels' | 'over';

/** A label, or an answer to a doubt. */
export type Choice = Pick<Label, 'id' | 'name' | 'color'>;

/** Choices that replace the labels; the first one is in the middle and cannot be taken. */
export interface Answers {
  readonly list: readonly Choice[];
  take(id: number): unknown;
}

export interface UpDownActs {
  /** Answers that the ring offers now; null: it offers labels. */
  answers(hand: Pointer): Answers | null;
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
  answers: Answers | null = null;
  private purpose: Purpose = 'none';
  private hand: Pointer | null = null;
  private readonly repeat = new Repeat();

  constructor(private readonly acts: UpDownActs) {}

  /** The choices on the ring. */
  get list(): readonly Choice[] {
    return this.answers?.list ?? peek(state.palette);
  }

  /** The choice in the middle of the ring. */
  get active(): number {
    return this.answers ? 0 : peek(state.activeLabel);
  }

  /** Once per picture, before the pad does anything else. */
  update(hand: Pointer | null, now: number): void {
    const same = hand !== null && hand === this.hand;
    this.hand = hand;
    if (same && hand.tracked && !hand.squeeze.down) this.follow(hand, now);
    else this.forget();
  }

  private follow(hand: Pointer, now: number): void {
    const { pad, pinching } = hand;
    this.updatePurpose(hand);
    this.updateTrigger(pinching);
    const idle = this.purpose === 'none' || this.purpose === 'over';
    const step = this.repeat.update(idle ? 0 : pad.y, now);
    if (this.purpose === 'levels' && step !== 0) this.acts.level(step);
    if (this.purpose === 'labels') this.push(hand, step);
    else this.mark(this.purpose === 'none' && !pinching ? -pad.over : 0);
  }

  private updatePurpose(hand: Pointer): void {
    const { pad, pinching } = hand;
    this.shown = pad.touched || pad.y !== 0;
    if (pad.y === 0) this.letGo();
    if (this.purpose !== 'none') return;
    this.answers = this.shown ? this.acts.answers(hand) : null;
    if (pad.y !== 0) this.purpose = pinching ? 'levels' : 'labels';
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
    const marked = this.list.length < 2 ? 0 : steps;
    if (marked === this.marked) return;
    this.marked = marked;
    if (marked !== 0) this.acts.marked();
  }

  /** The label that was marked is the stroke's; a level that is shown is the press's alone. */
  private updateTrigger(pinching: boolean): void {
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
    const { active, answers } = this;
    const next = labelBeside(this.list, active, this.marked);
    this.marked = 0;
    if (next === active) return;
    if (!answers) {
      actions.labels.selectLabel(next);
      this.acts.taken(this.hand!);
      return;
    }
    // A press that is held on does not answer the next question.
    this.purpose = 'over';
    answers.take(next);
  }

  /** Another hand paints, this one is out of sight, or the pad is its grip's: nothing is taken. */
  private forget(): void {
    this.purpose = 'over';
    this.shown = false;
    this.answers = null;
    this.marked = 0;
    this.repeat.update(0, 0);
  }
}

/** The choice so many steps below the active one in a list, round and round. */
export function labelBeside(palette: readonly Choice[], active: number, steps: number): number {
  const { length } = palette;
  const at = palette.findIndex(({ id }) => id === active);
  const from = at < 0 && steps < 0 ? 0 : at;
  return palette[(((from + steps) % length) + length) % length]?.id ?? active;
}
