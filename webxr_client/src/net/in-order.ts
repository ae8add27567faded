/** Work that is done in the order it came, though some of it has to wait. */
export class InOrder {
  private last: Promise<void> | null = null;

  /** Run work now, or after all earlier work; a failure does not stop later work. */
  add(work: () => void | Promise<void>): void {
    if (this.last === null) {
      const waiting = work();
      if (waiting) this.wait(waiting);
    } else {
      this.wait(this.last.then(work));
    }
  }

  private wait(waiting: Promise<void>): void {
    const last: Promise<void> = waiting.catch(reportError).then(() => {
      if (this.last === last) this.last = null;
    });
    this.last = last;
  }
}
