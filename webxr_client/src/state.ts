/**
 * The one client store.  The engine (net, cloud, tools) writes it; panels and the headset read it
 * and ask for changes through `actions`.  Brush and view settings are the user's own: panels may
 * write those two signals directly.
 *
 * Read with `.value` in components (they re-render), with `.peek()` in render loops.
 */
import { computed, Signal, signal, untracked, type ReadonlySignal } from '@preact/signals';
import type { Job, Label, SequenceInfo } from './protocol/messages';

// The library's own `peek` makes a closure at each call: too much for a loop of 90 pictures a second.
let peeked: Signal;
const readPeeked = (): unknown => peeked.value;
Signal.prototype.peek = function <T>(this: Signal<T>): T {
  peeked = this as Signal;
  return untracked(readPeeked) as T;
};

// ── connection and people ────────────────────────────────────────────────────────────────────

/** `refused`: wrong token, page older than the server, … — trying again will not help. */
export type ConnectionState = 'connecting' | 'online' | 'offline' | 'refused';

export interface Connection {
  readonly state: ConnectionState;
  /** One sentence for the user; empty when there is nothing to say. */
  readonly detail: string;
  /** `performance.now()` of the next try, or null. */
  readonly retryAt: number | null;
}

export interface Me {
  readonly viewer: string;
  readonly author: string;
  readonly role: 'viewer' | 'annotator' | 'reviewer' | 'admin';
  readonly serverVersion: string;
}

/** Position x, y, z then quaternion x, y, z, w; room coordinates, metres, y up. */
export type Pose = readonly [number, number, number, number, number, number, number];

export interface Person {
  readonly viewer: string;
  readonly name: string;
  readonly color: string;
  readonly frame: number;
  readonly head: Pose | null;
  readonly hands: readonly (Pose | null)[];
  readonly brush: readonly [number, number, number] | null;
  readonly radius: number;
  readonly label: number;
}

// ── recordings ───────────────────────────────────────────────────────────────────────────────

/** One row of the list of recordings, from REST. */
export interface SequenceSummary {
  readonly id: string;
  readonly name: string;
  readonly frames: number;
  readonly fps: number;
  /** Points of the largest frame. */
  readonly points: number;
}

/** What is on screen now. */
export interface Shown {
  readonly frame: number;
  /** Points loaded of `total`; fewer while the frame still sharpens. */
  readonly points: number;
  readonly total: number;
}

/** Frames [first, last] in the page's cache; `complete`: with all their points. */
export interface LoadedRange {
  readonly first: number;
  readonly last: number;
  readonly complete: boolean;
}

/** The timeline of one label: a value per frame. */
export interface TimelineRow {
  readonly points: Uint32Array;
  readonly painted: Uint32Array;
  /** 0..1; NaN where nothing was tracked. */
  readonly confidence: Float32Array;
  /** Index into `CELL_STATES`. */
  readonly state: Uint8Array;
}

export const CELL_STATES = ['none', 'painted', 'tracked', 'occluded', 'lost'] as const;

/** A new object at every change; the rows are updated in place. */
export interface TimelineTable {
  readonly rows: ReadonlyMap<number, TimelineRow>;
}

// ── tools ────────────────────────────────────────────────────────────────────────────────────

/** What a stroke does to points. */
export type StrokeTool = 'paint' | 'erase' | 'delete' | 'restore';

/**
 * What the button or trigger is for. `navigate`: moves the camera; `pick`: takes a label; `floor`:
 * points at what the recording stands on.
 */
export type Tool = StrokeTool | 'navigate' | 'pick' | 'floor';

/** Whether a tool makes strokes. */
export function isStroke(tool: Tool): tool is StrokeTool {
  return tool !== 'navigate' && tool !== 'pick' && tool !== 'floor';
}

/** How a stroke chooses points: under the brush, a region, a flat surface, an outline. */
export type BrushShape = 'brush' | 'fill' | 'plane' | 'lasso';

export interface BrushSettings {
  readonly shape: BrushShape;
  /** Metres. */
  readonly radius: number;
  readonly onlyUnlabeled: boolean;
  /** The brush also reaches points behind the first surface. */
  readonly through: boolean;
}

export const RADIUS_MIN = 0.005;
export const RADIUS_MAX = 5;

/** What is under the mouse or the controller's ray. */
export interface Hover {
  /** 0 unlabeled. */
  readonly label: number;
  /** Metres from the eye. */
  readonly distance: number;
  /** Points under the brush. */
  readonly points: number;
}

// ── view ─────────────────────────────────────────────────────────────────────────────────────

export type ColorMode = 'rgb' | 'intensity' | 'height' | 'plain';

export interface ViewSettings {
  readonly color: ColorMode;
  /** 1 = natural size. */
  readonly pointSize: number;
  /** 0 = recording's colours only, 1 = label colours only. */
  readonly labelBlend: number;
  /** 1 = as recorded. */
  readonly brightness: number;
  readonly eyeDome: boolean;
  readonly hideUnlabeled: boolean;
  readonly showDeleted: boolean;
  readonly grid: boolean;
  /** A box round each labelled object. */
  readonly boxes: boolean;
  /** The ways of the objects through the frames near the playhead. */
  readonly trails: boolean;
  /** Where the objects were in the frame before, faintly, while time stands. */
  readonly ghost: boolean;
}

// ── work and messages ────────────────────────────────────────────────────────────────────────

export interface HistoryEntry {
  readonly id: string;
  readonly revision: number;
  readonly author: string;
  /** ISO 8601. */
  readonly time: string;
  readonly kind: string;
  readonly summary: string;
  readonly points: number;
  /** Numbers of the frames it changed. */
  readonly frames: readonly number[];
  readonly undone: boolean;
}

/** A short message to the user; `error` stays until dismissed. */
export interface Notice {
  readonly id: number;
  readonly kind: 'info' | 'success' | 'error';
  readonly title: string;
  readonly detail: string;
}

/** Files on their way to the server, before the import job exists. */
export interface Upload {
  readonly name: string;
  readonly sent: number;
  readonly total: number;
}

export interface XrState {
  /** null until the browser answered. */
  readonly supported: boolean | null;
  readonly passthrough: boolean;
  readonly session: 'none' | 'starting' | 'running' | 'lost';
  readonly detail: string;
}

// ── the store ────────────────────────────────────────────────────────────────────────────────

export const state = {
  connection: signal<Connection>({ state: 'connecting', detail: '', retryAt: null }),
  me: signal<Me | null>(null),
  people: signal<readonly Person[]>([]),

  /** null until the server answered; empty when there are none. */
  sequences: signal<readonly SequenceSummary[] | null>(null),
  sequence: signal<SequenceInfo | null>(null),
  /** Id of the recording being opened, until its first points are on screen. */
  opening: signal<string | null>(null),

  /** The playhead, an integer frame number; what is drawn (`shown`) may lag behind it. */
  frame: signal(0),
  playing: signal(false),
  /** −16..16, times the recording's own rate. */
  speed: signal(1),
  loop: signal(true),
  shown: signal<Shown>({ frame: -1, points: 0, total: 0 }),
  loaded: signal<readonly LoadedRange[]>([]),

  palette: signal<readonly Label[]>([]),
  /** Label id → points in all frames together. */
  counts: signal<ReadonlyMap<number, number>>(new Map()),
  /** The label that painting gives; 0 when there is none. */
  activeLabel: signal(0),
  /** Only this label is shown; null when all are. */
  solo: signal<number | null>(null),
  timeline: signal<TimelineTable>({ rows: new Map() }),

  tool: signal<Tool>('paint'),
  brush: signal<BrushSettings>({
    shape: 'brush',
    radius: 0.05,
    onlyUnlabeled: false,
    through: false,
  }),
  hover: signal<Hover | null>(null),
  view: signal<ViewSettings>({
    color: 'rgb',
    pointSize: 1,
    labelBlend: 0.7,
    brightness: 1,
    eyeDome: true,
    hideUnlabeled: false,
    showDeleted: false,
    grid: true,
    boxes: false,
    trails: true,
    ghost: true,
  }),

  jobs: signal<readonly Job[]>([]),
  uploads: signal<readonly Upload[]>([]),
  /** What undo and redo would change, in words; null when there is nothing. */
  undo: signal<string | null>(null),
  redo: signal<string | null>(null),
  /** Newest first; filled when `actions.loadHistory` was called. */
  history: signal<readonly HistoryEntry[]>([]),
  /** Strokes that the server has not answered yet. */
  pending: signal(0),
  notices: signal<readonly Notice[]>([]),

  xr: signal<XrState>({ supported: null, passthrough: false, session: 'none', detail: '' }),
};

/** The active label's entry of the palette, or null. */
export const activeLabel: ReadonlySignal<Label | null> = computed(
  () => state.palette.value.find((label) => label.id === state.activeLabel.value) ?? null,
);

/** A tracking run in progress, or null. */
export const trackingJob: ReadonlySignal<Job | null> = computed(
  () => state.jobs.value.find((job) => job.kind === 'tracking' && isActive(job)) ?? null,
);

/** An import in progress, or null. */
export const importJob: ReadonlySignal<Job | null> = computed(
  () => state.jobs.value.find((job) => job.kind === 'import' && isActive(job)) ?? null,
);

/** Whether this person may change labels. */
export const canEdit: ReadonlySignal<boolean> = computed(() => state.me.value?.role !== 'viewer');

export function isActive(job: Job): boolean {
  return job.state === 'queued' || job.state === 'running';
}

/** Change some fields of a settings signal, e.g. `patch(state.brush, { radius: 0.1 })`. */
export function patch<T extends object>(target: Signal<T>, fields: Partial<T>): void {
  target.value = { ...target.peek(), ...fields };
}

let noticeId = 0;

/** Show a message; `info` and `success` leave by themselves. */
export function notify(kind: Notice['kind'], title: string, detail = ''): void {
  const notice: Notice = { id: ++noticeId, kind, title, detail };
  const same = (other: Notice): boolean => other.title === title && other.detail === detail;
  state.notices.value = [...state.notices.peek().filter((other) => !same(other)), notice].slice(-4);
  if (kind !== 'error') setTimeout(() => dismiss(notice.id), 4000);
}

export function dismiss(id: number): void {
  state.notices.value = state.notices.peek().filter((notice) => notice.id !== id);
}
