/** Input sources of a checked session: their kinds, and the buttons that were pressed. */
import type { HeadsetInput } from '../protocol/values';
import { pulsesBy } from '../xr/input/haptics';
import { buttonValue } from '../xr/input/kind';
import { kindOf } from '../xr/input/kinds';

/** From here on a button is pressed and an axis leaned. */
const HALF = 0.5;

class Seen {
  private readonly pressed = new Set<number>();
  private readonly leaned = new Set<number>();
  private joints: number | null = null;

  constructor(private source: XRInputSource) {}

  /** Record its state in a picture; sources that exist only during a press count as one. */
  note(source: XRInputSource, frame: XRFrame, space: XRReferenceSpace): void {
    this.source = source;
    const { gamepad, hand } = source;
    gamepad?.buttons.forEach((_, i) => buttonValue(gamepad, i) > HALF && this.pressed.add(i));
    gamepad?.axes.forEach((value, i) => Math.abs(value || 0) > HALF && this.leaned.add(i));
    if (!hand || !frame.getJointPose || this.joints === hand.size) return;
    let joints = 0;
    for (const joint of hand.values()) if (frame.getJointPose(joint, space)) joints += 1;
    this.joints = Math.max(this.joints ?? 0, joints);
  }

  /** Number of findings. */
  get findings(): number {
    return this.pressed.size + this.leaned.size + (this.joints ?? 0);
  }

  get report(): HeadsetInput {
    const { handedness: side, targetRayMode: mode, profiles, gamepad } = this.source;
    const kind = kindOf(this.source);
    return {
      side,
      mode,
      profiles: [...profiles],
      kind: kind?.name ?? '',
      layout: kind?.device(this.source).id ?? '',
      buttons: gamepad?.buttons.length ?? 0,
      axes: gamepad?.axes.length ?? 0,
      pressed: [...this.pressed].sort((a, b) => a - b),
      leaned: [...this.leaned].sort((a, b) => a - b),
      joints: this.joints,
      pulses: pulsesBy(gamepad),
    };
  }
}

export class Inputs {
  private readonly seen = new Map<string, Seen>();

  /** Another number whenever something was found. */
  changes = 0;

  /** Record the state of all sources, once for each picture. */
  note(sources: Iterable<XRInputSource>, frame: XRFrame, space: XRReferenceSpace): void {
    let changes = this.seen.size;
    for (const source of sources) {
      const { handedness, targetRayMode, profiles } = source;
      const key = [handedness, targetRayMode, ...profiles].join(' ');
      const seen = this.seen.get(key) ?? new Seen(source);
      this.seen.set(key, seen);
      seen.note(source, frame, space);
    }
    for (const { findings } of this.seen.values()) changes += findings;
    this.changes = changes;
  }

  /** List the seen inputs, in an order that does not depend on the order of their first use. */
  get reports(): HeadsetInput[] {
    const keys = [...this.seen.keys()].sort();
    return keys.map((key) => this.seen.get(key)!.report);
  }
}
