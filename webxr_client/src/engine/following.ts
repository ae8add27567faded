/**
 * "Follow": painted points are tracked on automatically once the stroke has settled, one label at a
 * time; the next stroke on the label stops that, and one undo takes back both.
 */
import type { Brush, Job, StrokeResult, Track } from '../protocol/messages';

/** A stroke has settled this long after its answer, milliseconds. */
const SETTLE_MS = 1000;

export interface FollowingDeps {
  readonly send: (message: Track) => void;
  readonly cancel: (job: string) => void;
  /** Whether it is switched on. */
  readonly on: () => boolean;
  /** A stroke is being drawn, or a job runs: not now. */
  readonly busy: () => boolean;
  /** Number of the recording's last frame. */
  readonly last: () => number;
  readonly later: (run: () => void, milliseconds: number) => () => void;
}

interface Painted {
  readonly stroke: string;
  readonly label: number;
  readonly frame: number;
}

interface Run extends Painted {
  /** Id of the request and of the edit that it makes. */
  readonly edit: string;
  job: string | null;
}

export class Following {
  /** Labels of strokes that paint and have no answer yet. */
  private readonly begun = new Map<string, number>();
  /** Runs to cancel once their job is known. */
  private readonly void = new Set<string>();
  /** Newest stroke of each label that waits for its run. */
  private readonly waiting = new Map<number, Painted>();
  private run: Run | null = null;
  /** The last run: done, and nothing was edited since. */
  private joined: Run | null = null;
  private timer: (() => void) | null = null;

  constructor(private readonly deps: FollowingDeps) {}

  /** Cancel the run of a label when a stroke on it begins. */
  begin(stroke: string, brush: Brush): void {
    this.joined = null;
    const label = brush.label ?? 0;
    if (brush.tool === 'paint') this.begun.set(stroke, label);
    this.waiting.delete(label);
    if (this.run?.label === label) this.stop();
  }

  /** A stroke was answered. */
  result(result: StrokeResult): void {
    if (!result.final) return;
    const label = this.begun.get(result.id);
    this.begun.delete(result.id);
    if (label === undefined || result.changed === 0 || !this.deps.on()) return;
    if (result.frame >= this.deps.last()) return;
    this.waiting.set(label, { stroke: result.id, label, frame: result.frame });
    this.wake(SETTLE_MS);
  }

  job(job: Job): void {
    const { run } = this;
    if (job.edit && this.void.delete(job.edit)) this.deps.cancel(job.id);
    if (!run || job.edit !== run.edit) return;
    run.job = job.id;
    if (job.state === 'queued' || job.state === 'running') return;
    this.run = null;
    if (job.state === 'done') this.joined = run;
    this.wake(0);
  }

  /** The server refused a request. */
  refused(about: string): boolean {
    if (this.run?.edit !== about) return false;
    this.run = null;
    this.wake(0);
    return true;
  }

  /** Stop the run; return the number of edits that an undo takes back. */
  undo(): number {
    const both = this.joined !== null;
    this.clear();
    return both ? 2 : 1;
  }

  /** Another recording, or another link. */
  clear(): void {
    this.timer?.();
    this.timer = null;
    this.waiting.clear();
    this.begun.clear();
    this.joined = null;
    this.stop();
  }

  private stop(): void {
    if (this.run?.job) this.deps.cancel(this.run.job);
    else if (this.run) this.void.add(this.run.edit);
    this.run = null;
  }

  private wake(milliseconds: number): void {
    this.timer?.();
    this.timer = null;
    if (this.waiting.size === 0) return;
    this.timer = this.deps.later(() => {
      this.timer = null;
      this.next();
    }, milliseconds);
  }

  private next(): void {
    const painted = this.waiting.values().next().value;
    if (!painted) return;
    if (this.run || this.deps.busy()) {
      this.wake(SETTLE_MS);
      return;
    }
    this.waiting.delete(painted.label);
    const edit = crypto.randomUUID();
    this.run = { ...painted, edit, job: null };
    this.joined = null;
    this.deps.send({
      type: 'track',
      id: edit,
      labels: [painted.label],
      start: painted.frame,
      stop: this.deps.last(),
      until_painted: true,
    });
  }
}
