/**
 * The one client store.  The engine (net, cloud, tools) writes it; panels and the headset read it
 * and ask for changes through `actions`.  Brush and view settings are the user's own: panels may
 * write these two signals directly.
 *
 * Read with `.value` in components (they re-render), with `peek` (`watch.ts`) in render loops.
 */
import { computed, signal, type ReadonlySignal, type Signal } from '@preact/signals';
import type { Compiling, Job, Label, SequenceInfo } from '../protocol/messages';
import type { PastEdit } from '../protocol/values';
import type {
  Connection,
  Me,
  Person,
  SequenceSummary,
  DeletedSequence,
  LoadedRange,
  TimelineTable,
  StrokeTool,
  Tool,
  BrushSettings,
  Hover,
  ObjectView,
  ViewSettings,
  Shown,
  Notice,
  Upload,
  ImportDraft,
  XrState,
} from './types';

export type * from './types';

export const CELL_STATES = ['none', 'painted', 'tracked', 'occluded', 'lost'] as const;

const STROKES: readonly Tool[] = ['paint', 'erase', 'delete', 'restore'];

/** Whether a tool makes strokes. */
export function isStroke(tool: Tool): tool is StrokeTool {
  return STROKES.includes(tool);
}

/** Whether a tool can leave points alone that have a label. */
export function sparesLabels(tool: Tool): boolean {
  return tool === 'paint' || tool === 'delete';
}

export const RADIUS_MIN = 0.005;
export const RADIUS_MAX = 5;

// ── the store ────────────────────────────────────────────────────────────────────────────────

export const state = {
  connection: signal<Connection>({ state: 'connecting', detail: '', retryAt: null, unsent: [] }),
  me: signal<Me | null>(null),
  people: signal<readonly Person[]>([]),

  /** null until the server answered; empty when there are none. */
  sequences: signal<readonly SequenceSummary[] | null>(null),
  /** Copies of recordings for one person each, which are in no list. */
  copies: signal<readonly SequenceSummary[]>([]),
  /** Deleted ones that can be restored, newest first. */
  deleted: signal<readonly DeletedSequence[]>([]),
  sequence: signal<SequenceInfo | null>(null),
  /** Id of the recording being opened, until its first points are on screen. */
  opening: signal<string | null>(null),
  /** The view has been chosen for the open recording, by its first picture. */
  framed: signal(false),

  /** The playhead, an integer frame number; the drawn frame (`shown`) may lag behind it. */
  frame: signal(0),
  playing: signal(false),
  /** −16..16, times the recording's own rate. */
  speed: signal(1),
  loop: signal(true),
  shown: signal<Shown>({ frame: -1, points: 0, total: 0 }),
  /** The graphics card dropped the picture, and the browser has not restored it yet. */
  pictureLost: signal(false),
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
    takeLabelled: false,
    complete: true,
    follow: false,
  }),
  hover: signal<Hover | null>(null),
  /** Candidate that the object tool offers or has taken; null when nothing. */
  object: signal<ObjectView | null>(null),
  /** The first answer for a place is still to come. */
  objectAsked: signal(false),
  view: signal<ViewSettings>({
    surface: 'auto',
    color: 'rgb',
    ramp: 'even',
    rampLow: 0,
    rampHigh: 1,
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
  /** Steps of compiling that the server is at, once on its machine, and their shares, 0..1. */
  compiling: signal<ReadonlyMap<Compiling['step'], number>>(new Map()),
  uploads: signal<readonly Upload[]>([]),
  /** Files that wait to be imported; null when there are none. */
  importing: signal<ImportDraft | null>(null),
  /** Summaries of the edits that undo and redo would take; null when there is none. */
  undo: signal<string | null>(null),
  redo: signal<string | null>(null),
  /** Newest first; filled when `actions.history.loadHistory` was called. */
  history: signal<readonly PastEdit[]>([]),
  /** Strokes that the server has not answered yet. */
  pending: signal(0),
  notices: signal<readonly Notice[]>([]),

  xr: signal<XrState>({
    supported: null,
    passthrough: false,
    enters: 'VR',
    session: 'none',
    detail: '',
  }),
};

/** The active label's entry of the palette, or null. */
export const activeLabel: ReadonlySignal<Label | null> = computed(
  () => state.palette.value.find((label) => label.id === state.activeLabel.value) ?? null,
);
/** The active label is hidden, here or for all: one cannot paint with it. */
export const activeLabelHidden: ReadonlySignal<boolean> = computed(() => {
  const label = activeLabel.value;
  const solo = state.solo.value;
  return label !== null && (!label.visible || (solo !== null && solo !== label.id));
});

/** A tracking run in progress, or null. */
export const trackingJob: ReadonlySignal<Job | null> = computed(
  () => state.jobs.value.find((job) => isTracking(job) && isOf(job, state.sequence.value)) ?? null,
);

function isOf({ sequence }: Job, open: SequenceInfo | null): boolean {
  return sequence === null || sequence === open?.id;
}

/** Whether this person began a job; true for every job until the account is known. */
export function isMine({ owner }: Pick<Job, 'owner'>): boolean {
  const me = state.me.value;
  return me === null || owner === '' || owner === me.account;
}

/** Return whether this person may stop a job: their own, or as a manager any job. */
export function canCancel(job: Pick<Job, 'owner'>): boolean {
  return canManage.value || (canEdit.value && isMine(job));
}

/** An import in progress, or null. */
export const importJob: ReadonlySignal<Job | null> = computed(
  () =>
    state.jobs.value.find((job) => job.kind === 'import' && isActive(job) && isMine(job)) ?? null,
);

/** Whether this person may change labels. */
export const canEdit: ReadonlySignal<boolean> = computed(() => includes('annotator'));

/** Whether this person may accept tracked labels. */
export const canReview: ReadonlySignal<boolean> = computed(() => includes('reviewer'));

/** Whether this person may import, rename and delete recordings. */
export const canManage: ReadonlySignal<boolean> = computed(() => includes('manager'));

/** Roles, from the least to the most. */
export const ROLES = ['viewer', 'annotator', 'reviewer', 'manager', 'admin'] as const;

/**
 * Whether this person's role includes another; true until the role is known, and false for
 * all once it refuses the page.
 */
function includes(role: (typeof ROLES)[number]): boolean {
  if (state.connection.value.state === 'refused') return false;
  const own = state.me.value?.role;
  return own === undefined || ROLES.indexOf(own) >= ROLES.indexOf(role);
}

export function isActive(job: Job): boolean {
  return job.state === 'queued' || job.state === 'running';
}

/** Whether a job is a tracking run that has not ended. */
export function isTracking(job: Job): boolean {
  return job.kind === 'tracking' && isActive(job);
}

/** Change some fields of a settings signal, e.g. `patch(state.brush, { radius: 0.1 })`. */
export function patch<T extends object>(target: Signal<T>, fields: Partial<T>): void {
  target.value = { ...target.peek(), ...fields };
}

let noticeId = 0;

/** Messages at once; of more the oldest goes that is no error. */
const MOST_NOTICES = 3;
const SHOWN_MS = 4000;
/** Time for which a message with an action to undo is shown, milliseconds. */
const SHOWN_WITH_ACTION_MS = 12_000;

/** Show a message, and return its id; `info` and `success` disappear after some seconds. */
export function notify(
  kind: Notice['kind'],
  title: string,
  detail = '',
  action?: Notice['action'],
): number {
  const others = state.notices.peek();
  const same = others.find((other) => other.title === title && other.detail === detail);
  const times = (same?.times ?? 0) + 1;
  const notice: Notice = { id: ++noticeId, kind, title, detail, times, ...(action && { action }) };
  const notices = [...others.filter((other) => other !== same), notice];
  while (notices.length > MOST_NOTICES) {
    const passing = notices.findIndex((other) => other.kind !== 'error' && !other.action?.stays);
    notices.splice(Math.max(0, passing), 1);
  }
  state.notices.value = notices;
  const shown = action ? SHOWN_WITH_ACTION_MS : SHOWN_MS;
  if (kind !== 'error' && !action?.stays) setTimeout(() => dismiss(notice.id), shown);
  return notice.id;
}

export function dismiss(id: number): void {
  state.notices.value = state.notices.peek().filter((notice) => notice.id !== id);
}
