/** The log of a session on its way to the server: numbered, and kept until the server has it. */
import type { LogPosition, LogRecord, LogRecords } from '../protocol/values';
import { keep, keptJson } from '../store/kept';

/** Most records of one message. */
const MOST = 1000;

export class Log {
  private readonly waiting: LogRecord[] = [];
  private sending: Promise<void> | null = null;

  /**
   * `first`: the server's next number; `key` keeps unsent records in this browser, for the next
   * page; `send` resolves with the server's next number.
   */
  constructor(
    private first: number,
    private readonly key: string,
    private readonly send: (records: LogRecords) => Promise<LogPosition>,
  ) {
    const left = keptJson(key) as LogRecords | null;
    if (left) this.waiting.push(...left.records.slice(Math.max(0, first - left.first)));
  }

  add(record: LogRecord): void {
    this.waiting.push(record);
  }

  /** Send all records; after a failure they wait for the next call. */
  flush(): Promise<void> {
    this.sending ??= this.sendAll().finally(() => (this.sending = null));
    return this.sending;
  }

  private async sendAll(): Promise<void> {
    const { waiting } = this;
    try {
      while (waiting.length > 0) {
        const records = waiting.slice(0, MOST);
        const { next } = await this.send({ first: this.first, records });
        waiting.splice(0, next - this.first);
        this.first = next;
      }
    } finally {
      this.keep();
    }
  }

  /** Keep the records that the server does not have. */
  keep(): void {
    const { first, waiting: records } = this;
    keep(this.key, JSON.stringify({ first, records }));
  }
}
