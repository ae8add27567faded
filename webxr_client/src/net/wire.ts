/** What page and worker tell each other. */
import type { ClientMessage, Open, ServerMessage } from '../protocol/messages';
import type { Segment } from './segment';

export type ToWorker =
  | { t: 'connect'; url: string; probe: string }
  | { t: 'send'; message: ClientMessage }
  | { t: 'open'; message: Open }
  | { t: 'close' }
  /** The page took in a segment; `buffers` are free again. */
  | { t: 'applied'; pace: Pace; buffers: ArrayBuffer[] }
  /** The pace changed by itself. */
  | { t: 'pace'; pace: Pace }
  | { t: 'recycle'; buffers: ArrayBuffer[] };

/** How the page keeps up: points of a frame that it can show in time, or null. */
export interface Pace {
  readonly points: number | null;
}

export type LinkState = 'connecting' | 'online' | 'offline' | 'refused';

/** An annotation with its packed arrays ready to use. */
export interface LabelUpdate {
  readonly sequence: string;
  readonly frame: number;
  readonly revision: number;
  readonly base: number | null;
  readonly edit: string | null;
  readonly provisional: boolean;
  readonly first: number;
  readonly count: number;
  /** Run lengths (whole) or sorted point numbers (delta). */
  readonly lengths: Uint32Array<ArrayBuffer>;
  readonly values: Uint16Array<ArrayBuffer>;
}

type Bulk = 'frame' | 'annotation';
export type PlainMessage = Exclude<ServerMessage, { type: Bulk }>;

export type FromWorker =
  | { t: 'link'; state: LinkState; detail: string; retryMs: number | null }
  | { t: 'message'; message: PlainMessage }
  /** Points, and the values that came just ahead of them. */
  | { t: 'segment'; segment: Segment; labels: LabelUpdate | null }
  | { t: 'labels'; update: LabelUpdate }
  /** Edits without an answer, of those that the worker had `heard` begin. */
  | { t: 'pending'; count: number; heard: number };
