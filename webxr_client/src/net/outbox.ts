/**
 * Edits that the server has not answered.  They survive a lost connection and a closed tab, and
 * are sent again in order; the server applies each id once.
 */
import type {
  ClientMessage,
  Redo,
  Sample,
  StrokeBegin,
  StrokeEnd,
  StrokeSamples,
  TouchedPoints,
  Track,
  Undo,
} from '../protocol/messages';
import type { Unsent } from './wire';

export type Edit = StrokeBegin | StrokeSamples | StrokeEnd | Undo | Redo | Track;

export interface OutboxEntry {
  readonly id: string;
  /** The import that it edits: another recording under the same name must not get it. */
  readonly recording: string;
  /** Time of the first message, which orders the entries. */
  readonly at: number;
  readonly first: StrokeBegin | Undo | Redo | Track;
  readonly samples: Sample[];
  ended: boolean;
  /** Points that the ended stroke takes, if the page sends them. */
  touched?: TouchedPoints[] | null;
}

export interface OutboxStorage {
  load(): Promise<OutboxEntry[]>;
  put(entry: OutboxEntry): void;
  remove(id: string): void;
}

/** An unfinished stroke of another tab may still be going on; older ones were cut off. */
const ABANDONED_MS = 10_000;
/** A stroke is saved whole each time: not with every batch of samples. */
const SAVE_MS = 250;
const SAMPLES_PER_MESSAGE = 1024;

export class Outbox {
  private readonly entries = new Map<string, OutboxEntry>();
  private last = 0;
  private saved = 0;

  constructor(
    private readonly storage: OutboxStorage,
    private readonly now: () => number = Date.now,
  ) {}

  /** Load the edits that an earlier page left. */
  async restore(): Promise<void> {
    for (const entry of await this.storage.load()) {
      if (this.entries.has(entry.id)) continue;
      if (!entry.ended && this.now() - entry.at < ABANDONED_MS) continue;
      entry.ended = true;
      this.entries.set(entry.id, entry);
    }
  }

  get size(): number {
    return this.entries.size;
  }

  /** Note an edit on its way out. */
  note(recording: string, message: Edit): void {
    if (message.type === 'stroke_samples' || message.type === 'stroke_end') {
      const entry = this.entries.get(message.id);
      if (!entry) return;
      if (message.type === 'stroke_samples') entry.samples.push(...message.samples);
      else Object.assign(entry, { ended: true, touched: message.touched });
      if (entry.ended || this.now() - this.saved > SAVE_MS) this.save(entry);
      return;
    }
    // Two edits within a millisecond keep their order.
    this.last = Math.max(this.now(), this.last + 0.001);
    const ended = message.type !== 'stroke_begin';
    const entry = { id: message.id, recording, at: this.last, first: message, samples: [], ended };
    this.entries.set(message.id, entry);
    this.save(entry);
  }

  private save(entry: OutboxEntry): void {
    this.saved = this.now();
    this.storage.put(entry);
  }

  /** The server answered, for good or ill. */
  settle(id: string): boolean {
    if (!this.entries.delete(id)) return false;
    this.storage.remove(id);
    return true;
  }

  /** Drop the edits of a deleted recording. */
  abandon(recording: string): boolean {
    const ids = this.of(recording).map((entry) => entry.id);
    return ids.filter((id) => this.settle(id)).length > 0;
  }

  /** Settle requests of tracking runs: a running job with another id is their answer. */
  settleTracks(): string[] {
    const ids = [...this.entries.values()]
      .filter((entry) => entry.first.type === 'track')
      .map((entry) => entry.id);
    return ids.filter((id) => this.settle(id));
  }

  /** Everything to send again after (re)opening a recording, in order. */
  resend(recording: string): ClientMessage[] {
    return this.of(recording).flatMap(messagesOf);
  }

  /** The strokes among them, oldest first. */
  strokes(): Unsent[] {
    const entries = [...this.entries.values()].sort((a, b) => a.at - b.at);
    return entries.flatMap(({ first }) => {
      if (first.type !== 'stroke_begin') return [];
      const { tool = 'paint', label = 0 } = first.brush;
      return [{ frame: first.frame, tool, label: tool === 'paint' ? label : 0 }];
    });
  }

  private of(recording: string): OutboxEntry[] {
    const entries = [...this.entries.values()].filter((entry) => entry.recording === recording);
    return entries.sort((a, b) => a.at - b.at);
  }
}

function messagesOf(entry: OutboxEntry): ClientMessage[] {
  const messages: ClientMessage[] = [entry.first];
  if (entry.first.type !== 'stroke_begin') return messages;
  for (let i = 0; i < entry.samples.length; i += SAMPLES_PER_MESSAGE) {
    const samples = entry.samples.slice(i, i + SAMPLES_PER_MESSAGE);
    messages.push({ type: 'stroke_samples', id: entry.id, samples });
  }
  if (entry.ended)
    messages.push({ type: 'stroke_end', id: entry.id, touched: entry.touched ?? null });
  return messages;
}

/** Whether an edit begins with a message; a stroke goes on in others. */
export function begins(message: ClientMessage): message is OutboxEntry['first'] {
  switch (message.type) {
    case 'stroke_begin':
    case 'undo':
    case 'redo':
    case 'track':
      return true;
    default:
      return false;
  }
}

export function isEdit(message: ClientMessage): message is Edit {
  return begins(message) || message.type === 'stroke_samples' || message.type === 'stroke_end';
}
