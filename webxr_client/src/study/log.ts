/** The log of a session on its way to the server: numbered, and kept until the server has it. */
import type { LogPosition, LogRecord, LogRecords } from '../protocol/values';
import { ApiError } from '../net/rest';

/** Most records of one message. */
const MOST = 1000;

export interface LogDeps {
  /** Send records; returns the server's next number. */
  readonly send: (records: LogRecords) => Promise<LogPosition>;
  /** Records that an earlier page left, or null. */
  readonly left: () => LogRecords | null;
  /** Keep records in this browser. */
  readonly keep: (records: LogRecords) => void;
}

export class Log {
  private readonly waiting: LogRecord[] = [];
  private sending: Promise<boolean> | null = null;

  /** `first`: the server's next number. */
  constructor(
    private first: number,
    private readonly deps: LogDeps,
  ) {
    const left = deps.left();
    if (left) this.waiting.push(...left.records.slice(Math.max(0, first - left.first)));
  }

  add(record: LogRecord): void {
    this.waiting.push(record);
  }

  /** Send all records; false: the server did not answer, and the records wait for the next call. */
  flush(): Promise<boolean> {
    this.sending ??= this.sendAll().finally(() => (this.sending = null));
    return this.sending;
  }

  private async sendAll(): Promise<boolean> {
    const { waiting } = this;
    while (waiting.length > 0) {
      try {
        const records = waiting.slice(0, MOST);
        const { next } = await this.deps.send({ first: this.first, records });
        waiting.splice(0, next - this.first);
        this.first = next;
      } catch (error) {
        this.keep();
        if (error instanceof ApiError && error.status === 0) return false;
        throw error;
      }
    }
    this.keep();
    return true;
  }

  /** Keep the records that the server does not have, for the next page. */
  keep(): void {
    this.deps.keep({ first: this.first, records: this.waiting });
  }
}
