/** Messages between the page, the socket's worker and the decoder. */
import type { ClientMessage, Depth, Frame, Open, ServerMessage } from '../protocol/messages';
import type { Segment } from './chunk/segment';

export type ToWorker =
  /** The way to the decoder. */
  | { t: 'decoder'; port: MessagePort }
  | { t: 'connect'; url: string; probe: string }
  | { t: 'send'; message: ClientMessage }
  | { t: 'open'; message: Open }
  | { t: 'close' }
  /** The page took in a segment. */
  | { t: 'applied'; pace: Pace }
  /** The pace changed without a segment. */
  | { t: 'pace'; pace: Pace };

/** The page to the decoder. */
export type FromPage =
  /** The way from the socket. */
  | { t: 'socket'; port: MessagePort }
  /** Segments' buffers that are free again. */
  | { t: 'recycle'; buffers: ArrayBuffer[] };

/** Pace of the page: points of a frame that it can show in time, or null. */
export interface Pace {
  readonly points: number | null;
}

/** A stroke that waits in this browser. */
export interface Unsent {
  readonly frame: number;
  readonly tool: string;
  /** 0 unless it paints. */
  readonly label: number;
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

type Bulk = 'frame' | 'depth' | 'annotation';
export type PlainMessage = Exclude<ServerMessage, { type: Bulk }>;

/** Messages that the decoder hands on as they are. */
type Plain =
  | {
      t: 'link';
      state: LinkState;
      detail: string;
      retryMs: number | null;
      unsent: readonly Unsent[];
    }
  | { t: 'message'; message: PlainMessage }
  | { t: 'labels'; update: LabelUpdate }
  /** Number of unanswered edits, when the worker had received `received` edits. */
  | { t: 'pending'; count: number; received: number };

/** The socket's worker to the decoder. */
export type ToDecoder =
  | Plain
  | { t: 'frame'; message: Frame }
  | { t: 'depth'; message: Depth }
  /** The page dropped these frames. */
  | { t: 'forget'; frames: readonly number[] };

/** The decoder back to the socket's worker, for each frame. */
export interface Decoded {
  readonly nbytes: number;
  readonly decodeMs: number;
}

/** Messages to the page, in the server's order. */
export type FromWorker =
  | Plain
  /** Points, and the values that came just ahead of them. */
  | { t: 'segment'; segment: Segment; labels: LabelUpdate | null };
