/** Haptics of the brush hand besides painting: a frame passed, a run ended, a label was locked. */
import { peek } from '../peek';
import { isActive, state } from '../state';
import { BUMP, FRAME_TICK, type Pulse } from './haptics';
import { follow } from '../watch';

export class Feelings {
  private frame = -1;
  private readonly unfollow: (() => void)[];

  constructor(private readonly feel: (pulse: Pulse) => void) {
    this.unfollow = [this.followJobs(), this.followLocks()];
  }

  /** Once per picture. */
  update(): void {
    const frame = peek(state.frame);
    if (frame === this.frame) return;
    // While it plays the hand would only buzz.
    if (this.frame >= 0 && !peek(state.playing)) this.feel(FRAME_TICK);
    this.frame = frame;
  }

  private followJobs(): () => void {
    let running = new Set<string>();
    return follow(() => {
      const tracking = state.jobs.value.filter((job) => job.kind === 'tracking');
      const active = new Set(tracking.filter(isActive).map((job) => job.id));
      const ended = [...running].some((id) => !active.has(id));
      running = active;
      if (ended) this.feel(BUMP);
    });
  }

  private followLocks(): () => void {
    let before: ReadonlySet<number> | null = null;
    return follow(() => {
      const palette = state.palette.value;
      const locked = new Set(palette.filter((label) => label.locked).map((label) => label.id));
      const more = before !== null && [...locked].some((id) => !before!.has(id));
      before = locked;
      if (more) this.feel(BUMP);
    });
  }

  dispose(): void {
    for (const stop of this.unfollow) stop();
  }
}
