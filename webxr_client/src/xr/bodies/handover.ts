/** Handedness while the wished hand is away: another hand takes over after a while, and never in a press. */
import type { Pointer } from '../input/pointer';
import type { Roles } from '../input/roles';
import type { Side } from '../../store/xr-settings';

/** Seconds without the wished hand after which another one paints. */
const PATIENCE = 1;

export class Handover {
  /** Seconds for which nothing of the wished hand has been there. */
  private readonly absent = new Float64Array(1);
  /** The input to which the brush goes as soon as it may, if any does. */
  private successor: Pointer | null = null;

  /** Return the roles that hold until a change of hands may happen. */
  roles(before: Roles<Pointer>, wanted: Roles<Pointer>, wished: Side): Roles<Pointer> {
    const { brush: from } = before;
    const { brush: to } = wanted;
    this.successor = null;
    if (!to || to === from) return wanted;
    const standsIn = from !== null && !from.leaving && !isOf(wished, from);
    const back = isOf(wished, to);
    // A stand-in finishes its stroke, and may give the brush to another input of its side.
    if (standsIn ? !back || !pressed(from) : back || this.mayTake(to)) return wanted;
    this.successor = to;
    return back ? before : { brush: null, other: to, palette: to.holds ? to : null };
  }

  /** Once per picture; true when the roles that wait may be asked for anew. */
  update(isPresent: boolean, holder: Pointer | null, seconds: Float64Array): boolean {
    this.absent[0] = isPresent ? 0 : this.absent[0]! + seconds[0]!;
    const { successor } = this;
    return successor !== null && (holder ? !pressed(holder) : this.mayTake(successor));
  }

  private mayTake(successor: Pointer): boolean {
    return this.absent[0]! >= PATIENCE && !pressed(successor);
  }
}

/** Whether an input is the wished hand's; one without a side is. */
export function isOf(wished: Side, { side }: Pointer): boolean {
  return side === wished || side === 'none';
}

function pressed({ pinching, squeeze }: Pointer): boolean {
  return pinching || squeeze.down;
}
