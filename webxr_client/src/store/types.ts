/** Types of the store's values: `state.ts` has the signals. */
import type { Unsent } from '../net/wire';
import type { Brush, ServerPresence, Welcome } from '../protocol/messages';
import type {
  ImportedLabels,
  ImportOptions as Corrections,
  ImportPreview,
  Manifest,
} from '../protocol/values';

// ── connection and people ────────────────────────────────────────────────────────────────────

/** `refused`: wrong token, page older than the server, … — trying again will not help. */
export type ConnectionState = 'connecting' | 'online' | 'offline' | 'refused';

export interface Connection {
  readonly state: ConnectionState;
  /** One sentence for the user, or empty. */
  readonly detail: string;
  /** `performance.now()` of the next try, or null. */
  readonly retryAt: number | null;
  /** Once refused: strokes that the server has not taken, oldest first. */
  readonly unsent: readonly Unsent[];
}

export interface Me {
  readonly viewer: string;
  /** The name shown, and the account that edits and jobs are by. */
  readonly author: string;
  readonly account: string;
  readonly role: Welcome['role'];
  readonly serverVersion: string;
}

/** Position x, y, z then quaternion x, y, z, w; room coordinates, metres, y up. */
export type Pose = readonly [number, number, number, number, number, number, number];

export type Person = Readonly<Omit<ServerPresence, 'type' | 'left'>>;

// ── recordings ───────────────────────────────────────────────────────────────────────────────

/** One row of the list of recordings. */
export interface SequenceSummary extends Omit<Manifest, 'points'> {
  /** Points of the largest frame. */
  readonly points: number;
}

/** A deleted recording that can still be restored. */
export interface DeletedSequence extends Manifest {
  readonly identity: string;
  readonly deleted: string;
  readonly until: string;
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

/** A new object at every change; the rows are updated in place. */
export interface TimelineTable {
  readonly rows: ReadonlyMap<number, TimelineRow>;
}

// ── tools ────────────────────────────────────────────────────────────────────────────────────

/** Action of a stroke on points. */
export type StrokeTool = 'paint' | 'erase' | 'delete' | 'restore';

/**
 * Use of the button or trigger. `navigate`: moves the camera; `pick`: takes a label; `floor`:
 * points at the floor; `boxes`: chooses and changes boxes of objects.
 */
export type Tool = StrokeTool | 'navigate' | 'pick' | 'floor' | 'boxes';

/** Shape of a stroke; the brush is a ball at the tip, or on the surface that a ray meets. */
export type BrushShape = Exclude<NonNullable<Brush['shape']>, 'sphere' | 'ray'> | 'brush';

export interface BrushSettings {
  readonly shape: BrushShape;
  /** Metres. */
  readonly radius: number;
  readonly onlyUnlabeled: boolean;
  /** The brush also reaches points behind the first surface. */
  readonly through: boolean;
  /** An object also takes points of other labels. */
  readonly takeLabelled: boolean;
  /** After a stroke the object that it lies on is offered. */
  readonly complete: boolean;
  /** Whether painted points are tracked on automatically. */
  readonly follow: boolean;
}

/** Target under the mouse or the controller's ray. */
export interface Hover {
  /** 0 unlabeled. */
  readonly label: number;
  /** Metres from the eye. */
  readonly distance: number;
  /** Points under the brush. */
  readonly points: number;
}

/** State of the tool that the panels and the room show. */
export interface ObjectView {
  /** Levels offered, from part to group, and the one shown. */
  readonly levels: number;
  readonly level: number;
  /** Points of that level. */
  readonly points: number;
  /** The whole frame is prepared; otherwise candidates come from points near the clicks. */
  readonly ready: boolean;
  /** An object was taken: clicks refine it. */
  readonly taken: boolean;
  /** The candidate is the object that a drawn stroke can be completed to. */
  readonly completes: boolean;
}

/** Three numbers: a place, or a direction. */
export type Vec = readonly [number, number, number];

/** Ray of a mouse, a controller or a hand, metres of the recording; `direction` of unit length. */
export interface PointerSample {
  readonly origin: Vec;
  readonly direction: Vec;
}

// ── view ─────────────────────────────────────────────────────────────────────────────────────

/**
 * Colouring of points. `normal`: by the direction of the surface. `confidence` and `provenance` colour each label by how sure tracking is
 * of it in this frame, and by the share of its points that a person painted.
 */
export type ColorMode =
  'rgb' | 'intensity' | 'height' | 'distance' | 'normal' | 'plain' | 'label' | 'confidence' | 'provenance' | 'sensor'; // prettier-ignore

/** Colours of values: perceptually even, grey, or of a rainbow. */
export type Ramp = 'even' | 'grey' | 'rainbow';

/** A depth camera's frame as points, as a surface, or as a surface where its points would show gaps. */
export type SurfaceMode = 'points' | 'surface' | 'auto';

export interface ViewSettings {
  readonly surface: SurfaceMode;
  readonly color: ColorMode;
  readonly ramp: Ramp;
  /** The part of the values that the ramp spans, 0..1. */
  readonly rampLow: number;
  readonly rampHigh: number;
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
  /** Ghost of the objects in the frame before, while time stands. */
  readonly ghost: boolean;
}

/** Description of the frame on screen. */
export interface Shown {
  readonly frame: number;
  /** Points loaded of `total`; fewer while the frame still sharpens. */
  readonly points: number;
  readonly total: number;
}

/** View that can be returned to. */
export interface View {
  readonly eye: Vec;
  readonly target: Vec;
  /** Half the height of an orthographic picture, metres; 0: perspective. */
  readonly half: number;
}

export interface Bookmark {
  readonly name: string;
  readonly frame: number;
  readonly view: View;
}

// ── work and messages ────────────────────────────────────────────────────────────────────────

/** A short message to the user; `error` stays until dismissed. */
export interface Notice {
  readonly id: number;
  readonly kind: 'info' | 'success' | 'error';
  readonly title: string;
  readonly detail: string;
  /** Number of equal messages while it was shown; the last one replaces the earlier ones. */
  readonly times: number;
  /** Button for a remedy or the next step; `stays`: until it is used. */
  readonly action?: {
    readonly label: string;
    readonly run: () => void;
    readonly stays?: boolean;
  };
}

/** Files on their way to the server, before the import job exists. */
export interface Upload {
  readonly name: string;
  readonly sent: number;
  readonly total: number;
}

/** A file, and where it lies below the folder that was chosen or dropped ("/" between names). */
export interface ChosenFile {
  readonly file: File;
  readonly path: string;
}

/** Corrections of a person to files; `columns` as one text with commas. */
export type ImportOptions = Omit<Corrections, 'columns'> & { readonly columns?: string };

/** Files on their way in: chosen here (and sent, `upload`), or a path of the server's machine. */
export interface ImportSource {
  readonly files: readonly ChosenFile[] | null;
  readonly path: string | null;
  readonly upload: string | null;
  readonly found: ImportPreview | null;
  readonly error: string;
}

/** One of several recordings. */
export interface ImportPart extends ImportSource {
  readonly name: string;
  readonly bytes: number;
  /** It is to be imported. */
  readonly included: boolean;
}

export interface ImportDraft extends ImportSource {
  /** The recording that gets the labels; null: the files are a new recording. */
  readonly sequence: string | null;
  /** The recordings that they are, where they are several. */
  readonly parts: readonly ImportPart[] | null;
  /** Whether it is known that they are one recording, several, or labels. */
  readonly decided: boolean;
  readonly options: ImportOptions;
  readonly labels: ImportedLabels | null;
  readonly busy: boolean;
}

export interface XrState {
  /** null until the browser answered. */
  readonly supported: boolean | null;
  /** Both are there: the button beside it enters with the real room in sight. */
  readonly passthrough: boolean;
  /** AR where that is all there is. */
  readonly enters: 'VR' | 'AR';
  readonly session: 'none' | 'starting' | 'running' | 'lost';
  readonly detail: string;
}
