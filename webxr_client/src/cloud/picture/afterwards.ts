/**
 * Work that can wait until a picture is displayed, mostly messages: posting one wakes
 * another thread, which may take this one's place on a busy processor.
 */
import { Listeners } from '../../store/listeners';
import { Timing } from './timing';

export class Afterwards {
  /** Work that runs after each call of `ask`. */
  readonly runs = new Listeners();
  readonly ms = new Timing();
  /** Whether times are taken. */
  measuring = false;
  private isScheduled = false;

  /** Run everything soon after this picture. */
  ask(): void {
    if (this.isScheduled) return;
    this.isScheduled = true;
    setTimeout(this.run);
  }

  private readonly run = (): void => {
    const started = this.measuring ? performance.now() : 0;
    this.isScheduled = false;
    this.runs.run();
    if (this.measuring) this.ms.add(performance.now() - started);
  };
}
