/** The page's own clock of a playing recording: frames follow it, it never waits for them. */

export class PlayClock {
  private start = 0;
  private since = 0;
  private rate = 0;
  private frames = 1;
  private loop = true;

  /** Begin at `frame` now; `speed` times `fps` frames a second, negative backward. */
  begin(
    frame: number,
    fps: number,
    speed: number,
    frames: number,
    loop: boolean,
    now: number,
  ): void {
    this.start = frame;
    this.since = now;
    this.rate = (fps * speed) / 1000;
    this.frames = frames;
    this.loop = loop;
  }

  get direction(): 1 | -1 {
    return this.rate < 0 ? -1 : 1;
  }

  /** The frame that should be seen at `now` (milliseconds). */
  frameAt(now: number): number {
    // Pictures are dated from when they begin, which may be before the press that began it.
    const moved = this.start + Math.max(0, now - this.since) * this.rate;
    const index = this.rate < 0 ? Math.ceil(moved) : Math.floor(moved);
    if (this.loop) return ((index % this.frames) + this.frames) % this.frames;
    return Math.min(this.frames - 1, Math.max(0, index));
  }

  /** Not looping, and past the last frame. */
  ended(now: number): boolean {
    if (this.loop) return false;
    const moved = this.start + (now - this.since) * this.rate;
    return this.rate < 0 ? moved < 0 : moved >= this.frames;
  }
}
