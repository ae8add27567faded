/**
 * Actions that a user can ask for, from a button, a key or a controller.  The engine implements these
 * (`bindActions`); before it does, they do nothing.
 */
import type { Label, Track } from '../protocol/messages';
import type { Bookmark, BrushShape, PointerSample, Tool, ViewSettings } from './types';

/** `labels` null: every label painted in the start frame; `stop` smaller than `start`: backward. */
export type TrackRequest = Readonly<Omit<Track, 'type' | 'id'>>;

export type ViewPreset = 'sensor' | 'top' | 'front' | 'left' | 'right' | 'fit';

/** Playing, and the frame on screen. */
export interface TimeActions {
  togglePlay(): void;
  play(): void;
  pause(): void;
  /** Frames forward (or back, negative); pauses. */
  step(frames: number): void;
  /** `scrubbing`: more seeks will follow at once (the finger is still down). */
  seek(frame: number, scrubbing?: boolean): void;
  setSpeed(speed: number): void;
  toggleLoop(): void;
  /** Next (1) or previous (−1) frame where nothing is labelled. */
  nextUnlabelled(direction: 1 | -1): void;
  /** The stretch of frames that is looped, tracked and exported begins, or ends, at this frame. */
  setIn(): void;
  setOut(): void;
  /** Next (1) or previous (−1) frame with doubtful or lost tracking. */
  nextDoubtful(direction: 1 | -1): void;
}

/** Tools, the brush, and strokes and outlines in progress. */
export interface ToolActions {
  setTool(tool: Tool): void;
  setShape(shape: BrushShape): void;
  setRadius(metres: number): void;
  /** One notch of [ and ]: 1 larger, −1 smaller. */
  nudgeRadius(notches: number): void;
  /** Cancel the stroke or outline in progress; false when there is none. */
  cancelStroke(): boolean;
  /** Close the drawn polygon, or take the points in the drawn box; false when there is neither. */
  closeOutline(): boolean;
  /** Take back the polygon's last corner; false when there is none. */
  takeBackCorner(): boolean;
  /** Put the box that is drawn on the ground under it; false when there is none. */
  snapBox(): boolean;
  /** Erase if painting, paint if erasing. */
  toggleEraser(): void;
  /** Levels of the object tool: 1 to the larger part, −1 to the smaller one; false when none shows. */
  stepObject(levels: number): boolean;
  /** Take the object that a stroke can be completed to; false when none is offered. */
  completeObject(): boolean;
  /** Make the next click begin another object. */
  endObject(): void;
  /** Put the desk's brush into the middle of the picture. */
  aimAtMiddle(): void;
  /** Use the tool there, as a click does: for hands without a mouse. */
  useInMiddle(): void;
}

/** The camera, the picture, and the stand of the recording on the floor. */
export interface ViewActions {
  setView(settings: Partial<ViewSettings>): void;
  viewFrom(preset: ViewPreset): void;
  /** Show only points in a box (null), or in a slab across an axis of the view: x, up, depth. */
  clipTo(slab: 0 | 1 | 2 | null): void;
  /** Between perspective and an orthographic picture. */
  toggleOrthographic(): void;
  /**
   * Fly to a label's object (the active one's): in `frame` once it is on screen, else where need be
   * in the nearest one that has it.
   */
  goToObject(label?: number, frame?: number): void;
  /** Keep how one looks now, and look so again. */
  keepView(): void;
  goToView(bookmark: Bookmark): void;
  /** Place the recording on the surface that a ray hits, and on the places chosen just before. */
  pointAtFloor(sample: PointerSample): Promise<void>;
  /** Stand the recording as it was imported. */
  resetFloor(): Promise<void>;
}

/** The palette, and labels in stretches of frames. */
export interface LabelActions {
  selectLabel(id: number): void;
  /** The n-th label as the palette lists them, from 1. */
  selectNthLabel(n: number): void;
  /** Without a name or colour the next good one is taken; the new label becomes active. */
  createLabel(name?: string, color?: string, category?: string): Promise<number>;
  /** The same at the desk: its name can be typed at once. */
  newLabel(): Promise<void>;
  updateLabel(id: number, patch: Partial<Label>): Promise<void>;
  renameLabel(id: number, name: string): Promise<void>;
  recolorLabel(id: number, color: string): Promise<void>;
  /** Give all labels that are not locked colours of this person's set, in their order. */
  recolorAll(): Promise<void>;
  toggleVisible(id: number): Promise<void>;
  toggleLock(id: number): Promise<void>;
  deleteLabel(id: number): Promise<void>;
  /** Give a label's points in all frames to another one, and remove it. */
  mergeLabel(id: number, into: number): Promise<void>;
  /** Give each connected part of a label in this frame a separate label. */
  splitLabel(id: number): Promise<void>;
  /** The label that was active before this one; false when there is none. */
  lastLabel(): boolean;
  /** Show only this label; again, or null: all of them. */
  solo(id: number | null): void;
  /** Take labels from all of their points in frames. */
  clearLabels(labels: readonly number[], from: number, to: number): Promise<void>;
  /** Copy labels from the points at the same place in another frame. */
  copyLabels(labels: readonly number[], source: number, frame: number): Promise<void>;
  /** Accept labels of a frame as they are. */
  acceptLabels(labels: readonly number[], frame: number): Promise<void>;
}

/** Edits, taken back and made again. */
export interface HistoryActions {
  undo(): void;
  redo(): void;
  loadHistory(): Promise<void>;
}

/** Tracking runs, and frames with doubtful labels. */
export interface TrackingActions {
  track(request: TrackRequest): void;
  /** Accept this frame: its doubtful labels count as painted. */
  acceptFrame(): Promise<void>;
  /** The same for all doubtful frames round this one. */
  acceptStretch(): Promise<void>;
  /** Clear the tracked points in the doubtful frames around this one. */
  clearStretch(): Promise<void>;
  /** Track the doubtful frames again, from the sure frame beside them. */
  trackStretch(): void;
  /** Track forward from this frame, to where a run that stopped was to go. */
  continueRun(): void;
  /** `keep`: the results so far stay (tracking). */
  cancelJob(id: string, keep?: boolean): Promise<void>;
}

/** The list of recordings, the open one, and the next task. */
export interface RecordingActions {
  refreshSequences(): Promise<void>;
  openSequence(id: string): void;
  closeSequence(): void;
  /** Begin the next task of a project, or continue the user's own task. */
  nextTask(project: string, work?: 'label' | 'review'): Promise<void>;
}

/** The connection, messages and the headset. */
export interface PageActions {
  reconnect(): void;
  dismissNotice(id: number): void;
  /** `passthrough`: the real room stays in sight. */
  enterVR(passthrough?: boolean): Promise<void>;
  exitVR(): Promise<void>;
  /** Open the studies of the workspace, for managers. */
  openStudies(): Promise<void>;
}

/** All actions, by domain. */
export interface Actions {
  readonly time: TimeActions;
  readonly tools: ToolActions;
  readonly view: ViewActions;
  readonly labels: LabelActions;
  readonly history: HistoryActions;
  readonly tracking: TrackingActions;
  readonly recordings: RecordingActions;
  readonly page: PageActions;
}

/** Implementations of some actions, by domain. */
export type ActionParts = { readonly [Domain in keyof Actions]?: Partial<Actions[Domain]> };

type Implementations = Record<string, unknown>;

const implemented: Record<keyof Actions, Implementations> = {
  time: {},
  tools: {},
  view: {},
  labels: {},
  history: {},
  tracking: {},
  recordings: {},
  page: {},
};

const nothing = (): Promise<void> => Promise.resolve();

function orNothing(domain: Implementations): Implementations {
  return new Proxy(domain, { get: (target, name: string) => target[name] ?? nothing });
}

/** Every action; an action without an implementation (yet) does nothing. */
export const actions = Object.fromEntries(
  Object.entries(implemented).map(([domain, part]) => [domain, orNothing(part)]),
) as unknown as Actions;

/** Implement some of the actions; the result takes them back. */
export function bindActions(parts: ActionParts): () => void {
  const given = Object.entries(parts) as [keyof Actions, Implementations][];
  for (const [domain, part] of given) Object.assign(implemented[domain], part);
  return () => {
    for (const [domain, part] of given) {
      const held = implemented[domain];
      for (const name of Object.keys(part)) {
        if (held[name] === part[name]) Reflect.deleteProperty(held, name);
      }
    }
  };
}
