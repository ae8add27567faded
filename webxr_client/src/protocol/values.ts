// Generated from values/ of server/pointbrush by
// `python -m pointbrush.streaming.typescript --write`.
// Do not edit: a stale file fails the tests.

/** An account with its tokens. */
export interface Account {
  /** Name of the account. */
  readonly account: string;
  /** Highest role of its valid tokens; null: none is valid.  `viewer`: sees recordings and labels; `annotator`: changes labels; `reviewer`: accepts and rejects labels; `manager`: manages recordings, projects and accounts; `admin`: manages the server */
  readonly role: 'viewer' | 'annotator' | 'reviewer' | 'manager' | 'admin' | null;
  /** Its tokens, oldest first. */
  readonly tokens: readonly Token[];
}

/** Result of an addition to the palette. */
export interface AddedLabels {
  /** Names of the new labels. */
  readonly added: readonly string[];
}

/** Agreement of two annotations of the same points. */
export interface Agreement {
  /** Mean of the labels' IoU, 0 to 1; null if neither has labels. */
  readonly miou: number | null;
  /** Share of labelled points with equal labels, 0 to 1; null if neither has labels. */
  readonly same: number | null;
  /** Agreement by label. */
  readonly labels: readonly LabelAgreement[];
  /** Agreement by frame. */
  readonly frames: readonly FrameAgreement[];
  /** Agreement of boxes, only on request. */
  readonly boxes: BoxAgreement | null;
}

/** Axis-aligned bounds over all frames, source coordinates. */
export interface Bounds {
  /** Corner with the smallest x, y and z, metres. */
  readonly lo: readonly [number, number, number];
  /** Corner with the greatest x, y and z, metres. */
  readonly hi: readonly [number, number, number];
}

/** An oriented box of a label. */
export interface Box {
  /** Number of the box, never given to another box of the recording. */
  readonly id: number;
  /** Id of the label. */
  readonly label: number;
  /** Length, width and height along the box's x, y and z, metres. */
  readonly size: readonly [number, number, number];
  /** Pose in each frame, by the frame's number. */
  readonly poses: Readonly<Record<string, BoxPose>>;
  /** Attributes of the box in all frames, by name. */
  readonly attributes: Readonly<Record<string, string | number | boolean>>;
  /** Origin of the box. `fitted`: fitted to the label's points; `drawn`: drawn or moved by a person; `imported`: read from a file */
  readonly provenance: 'fitted' | 'drawn' | 'imported';
  /** False: the front of the object may also be at the opposite end of the box. */
  readonly heading_known: boolean;
}

/** Agreement of boxes. */
export interface BoxAgreement {
  /** Agreement by class. */
  readonly classes: readonly ClassAgreement[];
  /** Higher order tracking accuracy, 0 to 1; null without boxes or the package trackeval. */
  readonly hota: number | null;
}

/** An attribute that boxes may have beside ``occluded``, ``truncated`` and ``parked``. */
export interface BoxAttribute {
  /** Key in the ``attributes`` of a box or of its pose. */
  readonly name: string;
  /** Type of its values. `text`: any text; `choice`: one of ``choices``; `number`: a number; `yes/no`: true or false */
  readonly kind: 'text' | 'choice' | 'number' | 'yes/no';
  /** Place of its values. `track`: one value for the box; `frame`: one value in each frame */
  readonly scope: 'track' | 'frame';
  /** Values of the kind ``choice``; other kinds have none. */
  readonly choices: readonly string[];
}

/** A box after its edit, which is durable. */
export interface BoxEdit {
  /** The box. */
  readonly box: Box;
  /** UUID of the edit. */
  readonly edit: string;
  /** Revision of the recording after the edit. */
  readonly revision: number;
}

/** Labels to fit boxes to. */
export interface BoxFit {
  /** Ids of labels; null: all labels. */
  readonly labels?: readonly number[] | null;
  /** Only labels of this category; null: of any. */
  readonly category?: string | null;
  /** Frames ``I:J``; null: all frames. */
  readonly frames?: string | null;
  /** Also replace poses that a person has drawn. */
  readonly redraw?: boolean;
  /** UUID of the job and of its edit: a repeated call does not begin another job. */
  readonly id?: string | null;
}

/** Pose of a box in one frame. */
export interface BoxPose {
  /** Centre of the box, source coordinates, metres. */
  readonly centre: readonly [number, number, number];
  /** x, y, z, w: from the box's axes (x forward, y left, z up) to the axes of the frame. */
  readonly quaternion: readonly [number, number, number, number];
  /** Origin of the pose. `fitted`: fitted to the label's points; `drawn`: drawn or moved by a person; `imported`: read from a file */
  readonly provenance: 'fitted' | 'drawn' | 'imported';
  /** Confidence in the pose, 0 to 1. */
  readonly confidence: number;
  /** Attributes in this frame, by name; they take precedence over the box's. */
  readonly attributes: Readonly<Record<string, string | number | boolean>>;
}

/** Boxes of the second annotation compared with the first. */
export interface BoxScore {
  /** Smallest 3D intersection over union of boxes that match. */
  readonly iou: number;
  /** Average precision, 0 to 1. */
  readonly ap: number;
  /** Share of the second's boxes that match, 0 to 1. */
  readonly precision: number;
  /** Share of the first's boxes that match, 0 to 1. */
  readonly recall: number;
}

/** A camera with a picture; a point p in source coordinates is at ``K (T_camera_frame p)``. */
export interface Camera {
  /** Name of the camera in URLs. */
  readonly name: string;
  /** Width of the picture, pixels. */
  readonly width: number;
  /** Height of the picture, pixels. */
  readonly height: number;
  /** Matrix (3, 3) to pixels; null: unknown. */
  readonly K: readonly (readonly number[])[] | null;
  /** Coefficients of ``model``; none: the picture is rectified. */
  readonly distortion: readonly number[];
  /** Model of the lens, such as ``plumb_bob`` with k1, k2, p1, p2, k3. */
  readonly model: string;
  /** Transform (4, 4) to the camera: x right, y down, z forward; null: unknown. */
  readonly T_camera_frame: readonly (readonly number[])[] | null;
}

/** A class of the workspace; its number is the same in every export and never changes. */
export interface Category {
  /** 1 to 65535. */
  readonly number: number;
  /** Text that people see; a new name changes no number. */
  readonly name: string;
  /** ``#rrggbb``; empty: none. */
  readonly color: string;
  /** Its numbers in other datasets, by name of the dataset. */
  readonly datasets: Readonly<Record<string, number>>;
  /** Mean length, width and height of its objects, metres; null: unknown or unchanged. */
  readonly size: readonly [number, number, number] | null;
  /** Standard deviation of the size, metres; null: unknown or unchanged. */
  readonly spread: readonly [number, number, number] | null;
}

/** Findings, and parts that could not be checked. */
export interface Checked {
  /** Findings in order of importance. */
  readonly findings: readonly Finding[];
  /** A sentence for each skipped check. */
  readonly unchecked: readonly string[];
}

/** One row of a frame's chunk table; a point is at ``origin + q * scale``, local metres. */
export interface Chunk {
  /** Number of the chunk in the frame, from 0. */
  readonly index: number;
  /** Level of detail, 0 the coarsest. */
  readonly level: number;
  /** Stored number of its first point. */
  readonly first: number;
  /** Number of its points. */
  readonly count: number;
  /** Place of its bytes in the frame's wire file, bytes. */
  readonly offset: number;
  /** Length of its bytes. */
  readonly nbytes: number;
  /** Position of the quantised point 0, 0, 0. */
  readonly origin: readonly [number, number, number];
  /** Metres per step of a quantised coordinate. */
  readonly scale: readonly [number, number, number];
  /** Corner of its points with the smallest x, y and z, local metres. */
  readonly lo: readonly [number, number, number];
  /** Corner of its points with the greatest x, y and z, local metres. */
  readonly hi: readonly [number, number, number];
  /** Number of the chunk above in an octree; -1: none. */
  readonly parent: number;
  /** Number of the sensor of its points, in whose coordinates ``origin`` and ``scale`` are; null: the recording has one sensor. */
  readonly sensor: number | null;
}

/** All chunks of a frame. */
export interface ChunkTable {
  /** Number of the frame. */
  readonly frame: number;
  /** Number of its points. */
  readonly points: number;
  /** Id of the import, which makes the URL of a chunk unique for ever. */
  readonly identity: string;
  /** Its chunks in stored order. */
  readonly chunks: readonly Chunk[];
}

/** Agreement on the boxes of a class, counted in each frame. */
export interface ClassAgreement {
  /** Name of the class. */
  readonly name: string;
  /** Number of boxes in the first annotation. */
  readonly first: number;
  /** Number of boxes in the second annotation. */
  readonly second: number;
  /** Mean 3D intersection over union of overlapping boxes; null: none overlap. */
  readonly mean_iou: number | null;
  /** Scores by smallest overlap. */
  readonly scores: readonly BoxScore[];
}

/** Figures of a class. */
export interface ClassFigures {
  /** Name of the class. */
  readonly name: string;
  /** Number of its points. */
  readonly points: number;
  /** Number of its labels with points. */
  readonly objects: number;
  /** Hours of editing, by the class's share of painted points. */
  readonly hours: number;
}

/** A classifier of the workspace. */
export interface Classifier {
  /** Name in URLs. */
  readonly id: string;
  /** Text that people see. */
  readonly name: string;
  /** Names of its classes; predictions number them from 1. */
  readonly classes: readonly string[];
  /** Number of its examples, by id of the recording. */
  readonly taught_by: Readonly<Record<string, number>>;
  /** Number of its examples, by class. */
  readonly examples: Readonly<Record<string, number>>;
  /** Expected share of correct points in its recordings, 0 to 1; null: not measured. */
  readonly score: number | null;
  /** Side of a cell of features, metres; 0 before the first training. */
  readonly cell: number;
  /** Name of the model that predicts; empty: trees. */
  readonly model: string;
  /** It learns from imported labels as well. */
  readonly imported: boolean;
  /** Accuracy in held-out places, by class. */
  readonly held_out: Readonly<Record<string, HeldOut>>;
  /** Default limit of the confidence of labels that it applies, 0 to 1. */
  readonly above: number;
  /** Ids of the labelled recordings that it began with. */
  readonly start_from: readonly string[];
}

/** One way of labelling that the study compares. */
export interface Condition {
  /** Name in results. */
  readonly name: string;
  /** Device of the participant: a window at the `desk`, or a `headset`. */
  readonly device: 'desk' | 'headset';
  /** Input: `mouse` and keyboard, `controller` of a headset, `hands`, or `look-and-pinch`. */
  readonly input: 'mouse' | 'controller' | 'hands' | 'look-and-pinch';
  /** Names of the page's tools that are shown; empty: all. */
  readonly tools: readonly string[];
  /** The page shows hints. */
  readonly hints: boolean;
  /** Text before the first task of the condition. */
  readonly instructions: string;
}

/** Agreement of two copies of a recording. */
export interface CopyAgreement {
  /** Id of the first copy. */
  readonly first: string;
  /** Id of the second copy. */
  readonly second: string;
  /** Agreement of their labels. */
  readonly agreement: Agreement;
  /** Places where they differ, the largest first. */
  readonly places: readonly Disagreement[];
}

/** An event and its delivery. */
export interface Delivery {
  /** Id of the event, which a receiver may use to drop repetitions. */
  readonly id: string;
  /** Kind of the event. `task`: changes of tasks; `labels`: edits, at most once a minute for a recording; `job`: jobs that have ended */
  readonly topic: 'task' | 'labels' | 'job';
  /** Time of the event. */
  readonly created: string;
  /** Number of attempts to deliver it. */
  readonly attempts: number;
  /** Time of its delivery; null: not yet. */
  readonly delivered: string | null;
  /** Reason of the last failure, or empty. */
  readonly error: string;
}

/** Difference of a recording's labels between two versions; equal parts are left out. */
export interface Difference {
  /** Id of the recording. */
  readonly sequence: string;
  /** Labels that differ. */
  readonly labels: readonly LabelDifference[];
  /** Frames with points that differ. */
  readonly frames: readonly FrameDifference[];
}

/** A difference of two copies in a frame. */
export interface Disagreement {
  /** Kind of difference. `missed`: the second has no label there; `added`: the first has no label there; `split`: one label of the first is several of the second; `merged`: several labels of the first are one of the second; `renamed`: the label has another name; `outline`: the labels have other outlines */
  readonly kind: 'missed' | 'added' | 'split' | 'merged' | 'renamed' | 'outline';
  /** Number of the frame. */
  readonly frame: number;
  /** Names of the labels in the first copy. */
  readonly first: readonly string[];
  /** Names of the labels in the second copy. */
  readonly second: readonly string[];
  /** Ids of these labels in the first and in the second copy. */
  readonly labels: readonly (readonly number[])[];
  /** Number of differing points. */
  readonly points: number;
  /** 0: the recording has the label of the first copy, 1: of the second; null: of neither. */
  readonly has: number | null;
  /** A differing point, source coordinates, metres; null in an octree. */
  readonly place: readonly [number, number, number] | null;
}

/** A file or folder in a folder on the server. */
export interface Entry {
  /** Name of the entry. */
  readonly name: string;
  /** Path on the server. */
  readonly path: string;
  /** Size of the file, or of all files in the folder. */
  readonly bytes: number;
}

/** An export format. */
export interface ExportFormat {
  /** Name for the ``format`` of an export. */
  readonly format: string;
  /** Name that people see. */
  readonly title: string;
  /** Contents of its files. */
  readonly content: string;
  /** Heading of the page's list. */
  readonly purpose: string;
  /** Content that is lost in it. */
  readonly cannot_hold: readonly string[];
  /** Its frames are split for training and validation. */
  readonly splits: boolean;
  /** It has whole boxes, not boxes that enclose only the visible points. */
  readonly whole_boxes: boolean;
  /** A label without a category becomes a class of its own in it. */
  readonly classes: boolean;
}

/** A file, and the frame that it is or belongs to. */
export interface FileFrame {
  /** Path of the file. */
  readonly file: string;
  /** Number of the frame. */
  readonly frame: number;
}

/** A suspicious place or label; its ``id`` is the same in every check until it is gone. */
export interface Finding {
  /** Id, unique in the recording. */
  readonly id: string;
  /** Check that found it. `name`: two labels have one name; `category`: a label has no category; `few`: a label has few points; `stray`: points are far from their object; `jump`: a track jumps; `unlike`: a frame differs from its neighbours; `predicted`: a classifier labelled points with low confidence; `returned`: a label was found again, in doubt, after it was hidden; `box_jump`: a box jumps or turns between frames; `box_size`: a box has another size than its class; `box_overlap`: two boxes overlap; `box_ground`: a box floats above the ground or is sunk in it; `box_empty`: a box contains no points; `box_outside`: points of the label are outside its box; `box_heading`: the heading of a box contradicts its motion */
  readonly kind: 'name' | 'category' | 'few' | 'stray' | 'jump' | 'unlike' | 'predicted' | 'returned' | 'box_jump' | 'box_size' | 'box_overlap' | 'box_ground' | 'box_empty' | 'box_outside' | 'box_heading';
  /** Sentence for people. */
  readonly text: string;
  /** Ids of its labels; empty: about frames. */
  readonly labels: readonly number[];
  /** First frame; null: about the palette. */
  readonly first: number | null;
  /** Last frame, included. */
  readonly last: number | null;
  /** Position in frame ``first``, source coordinates, metres. */
  readonly place: readonly [number, number, number] | null;
  /** Its frames or labels are accepted. */
  readonly settled: boolean;
}

/** Result of a fit of boxes, which is one edit. */
export interface FittedBoxes {
  /** UUID of the edit; null: no box was fitted. */
  readonly edit: string | null;
  /** Ids of the fitted boxes. */
  readonly fitted: readonly number[];
  /** Reason for each skipped label, by its id. */
  readonly skipped: Readonly<Record<string, string>>;
}

/** People in the searched frames; no label was changed. */
export interface FoundPeople {
  /** Class of their labels. */
  readonly category: string;
  /** Number of searched frames. */
  readonly searched: number;
  /** The people, the nearest first. */
  readonly people: readonly FoundPerson[];
}

/** A person in the searched frames. */
export interface FoundPerson {
  /** Name of the label that the person gets. */
  readonly name: string;
  /** Colour of this label. */
  readonly color: string;
  /** Id of this label; null: a new one. */
  readonly label: number | null;
  /** The person's points in each frame with the person, in the order of the frames. */
  readonly frames: readonly PersonPoints[];
}

/** Agreement in a frame. */
export interface FrameAgreement {
  /** Number of the frame. */
  readonly frame: number;
  /** Number of points that either annotation labels. */
  readonly labelled: number;
  /** Number of these points with different labels. */
  readonly differ: number;
}

/** Points of a frame that differ between two versions. */
export interface FrameDifference {
  /** Number of the frame. */
  readonly frame: number;
  /** Number of points that got a label. */
  readonly came: number;
  /** Number of points that lost their label. */
  readonly went: number;
  /** Number of points with another label. */
  readonly changed: number;
  /** Ids of labels with points in the later version alone. */
  readonly objects_came: readonly number[];
  /** Ids of labels with points in the earlier version alone. */
  readonly objects_went: readonly number[];
}

/** A requested feature; ``granted`` is null if the browser does not report it. */
export interface HeadsetFeature {
  /** Name of the WebXR feature. */
  readonly name: string;
  /** The session has it; null: the browser does not report it. */
  readonly granted: boolean | null;
}

/**
 * An input source and its observed properties.
 *
 * ``kind`` and ``layout`` are the page's classification, empty if unknown; ``pressed`` and
 * ``leaned`` are numbers of used buttons and axes; ``joints`` is null without a hand.
 */
export interface HeadsetInput {
  /** Hand of the source: `left`, `right` or `none`. */
  readonly side: 'left' | 'right' | 'none';
  /** WebXR target ray mode. */
  readonly mode: string;
  /** WebXR input profiles, the most specific first. */
  readonly profiles: readonly string[];
  /** Classification by the page; empty: unknown. */
  readonly kind: string;
  /** Layout of its buttons by the page; empty: unknown. */
  readonly layout: string;
  /** Number of its buttons. */
  readonly buttons: number;
  /** Number of its axes. */
  readonly axes: number;
  /** Numbers of the buttons that were pressed. */
  readonly pressed: readonly number[];
  /** Numbers of the axes that were moved. */
  readonly leaned: readonly number[];
  /** Number of tracked joints; null: no hand. */
  readonly joints: number | null;
  /** Interface for vibration: `hapticActuators`, `vibrationActuator` or `none`. */
  readonly pulses: 'hapticActuators' | 'vibrationActuator' | 'none';
}

/** The layer to draw to; ``foveation`` is null if the browser has none. */
export interface HeadsetLayer {
  /** Layer to draw to: `projection` or `webgl`. */
  readonly kind: 'projection' | 'webgl';
  /** Width of its texture, pixels. */
  readonly width: number;
  /** Height of its texture, pixels. */
  readonly height: number;
  /** Number of views. */
  readonly views: number;
  /** Fixed foveation, 0 to 1; null: the browser has none. */
  readonly foveation: number | null;
  /** Distance of the near plane, metres. */
  readonly depth_near: number;
  /** Distance of the far plane, metres. */
  readonly depth_far: number;
}

/**
 * Times between pictures while the recording played.
 *
 * ``told`` is the display rate reported by the browser, ``offered`` the available rates, ``found``
 * the measured rate; a picture is ``late`` if it misses a refresh at the reported rate, or else
 * the measured one.
 */
export interface HeadsetPictures {
  /** Display rate that the browser reports, hertz; null: none. */
  readonly told: number | null;
  /** Display rates that the browser offers, hertz. */
  readonly offered: readonly number[];
  /** Measured display rate, hertz. */
  readonly found: number;
  /** Number of pictures. */
  readonly count: number;
  /** Median time between pictures, milliseconds. */
  readonly median_ms: number;
  /** Time between pictures that 95 % stay below, milliseconds. */
  readonly p95_ms: number;
  /** Number of pictures that missed a refresh. */
  readonly late: number;
}

/** A report, the account that sent it, and the time at which it arrived. */
export interface HeadsetReport {
  /** Id of the report. */
  readonly id: string;
  /** Account that sent it. */
  readonly account: string;
  /** Time at which it arrived. */
  readonly received: string;
  /** The report, as the page made it. */
  readonly report: HeadsetReportFile;
}

/** The whole file; ``trouble``: why no session started; ``session``: null without a session. */
export interface HeadsetReportFile {
  /** Kind of the file: `pointbrush headset report`. */
  readonly format: 'pointbrush headset report';
  /** Version of the format. */
  readonly version: 1;
  /** Time of the report, ISO 8601. */
  readonly made: string;
  /** Version of pointbrush. */
  readonly pointbrush: string;
  /** User agent of the browser. */
  readonly browser: string;
  /** Reason why no session started; empty: one started. */
  readonly trouble: string;
  /** Initial state of the session; null: none. */
  readonly session: HeadsetSession | null;
  /** Input sources. */
  readonly inputs: readonly HeadsetInput[];
  /** Times between pictures; null: not measured. */
  readonly pictures: HeadsetPictures | null;
  /** Tasks and their outcomes. */
  readonly tasks: readonly HeadsetTask[];
}

/** The initial state of a session; ``floor``: its space has the height of the floor. */
export interface HeadsetSession {
  /** WebXR session mode. */
  readonly mode: string;
  /** Environment blend mode. */
  readonly blend: string;
  /** The space has the height of the floor. */
  readonly floor: boolean;
  /** Requested features. */
  readonly features: readonly HeadsetFeature[];
  /** Reference spaces. */
  readonly spaces: readonly HeadsetSpace[];
  /** Layer to draw to. */
  readonly layer: HeadsetLayer;
}

/** A reference space, and whether the session provides it. */
export interface HeadsetSpace {
  /** Type of the WebXR reference space. */
  readonly name: string;
  /** The session provides it. */
  readonly given: boolean;
}

/** A task; ``by_buttons``: it was done by a button or pad of a controller, not a panel. */
export interface HeadsetTask {
  /** Tried action: `play`, `felt` a vibration, `paint`, `erase`, choose a `label`, `undo`, `step` a frame, or `go` somewhere. */
  readonly name: 'play' | 'felt' | 'paint' | 'erase' | 'label' | 'undo' | 'step' | 'go';
  /** Outcome: `works`, `fails` or `unknown`. */
  readonly verdict: 'works' | 'fails' | 'unknown';
  /** It was done by a button or pad of a controller, not a panel. */
  readonly by_buttons: boolean;
}

/** Accuracy of a class in places that the training did not see. */
export interface HeldOut {
  /** Expected share of correct points, 0 to 1; null: too few places. */
  readonly accuracy: number | null;
  /** Number of its painted places. */
  readonly places: number;
}

/** Corrections by a person to an import's files; null: as found in the files. */
export interface ImportOptions {
  /** Name of the recording; null: of the file or folder. */
  readonly name?: string | null;
  /** Frames per second of playback, at most 1000. */
  readonly fps?: number | null;
  /** Format of the files, such as ``ply``; null: detected. */
  readonly format?: string | null;
  /** Meanings of the columns in their order: x,y,z,intensity,red,green,blue,label,instance, or ``-`` for a column to leave out; or pairs: ``scalar_Foo=label``; also one text with commas. */
  readonly columns?: readonly string[] | null;
  /** Separator of the columns of text files: one character, or comma, semicolon, tab, space or pipe. */
  readonly delimiter?: string | null;
  /** Numbers in text files have a decimal comma: 1,5 is one and a half. */
  readonly decimal_comma?: boolean | null;
  /** Metres per unit of the files and their poses: 0.001 for millimetres; null: 1. */
  readonly scale?: number | null;
  /** Axis of the coordinates that points up, such as ``z`` or ``-y`` (``--up=-y``). */
  readonly up?: string | null;
  /** Topic of a bag to read; ``topic#frame_id`` if sensors share a topic; several, also as one text with commas: the topics of the sensors of one recording, the reference first. */
  readonly topic?: string | null;
  /** Sensors of a bag or a dataset to read. `one`: the main sensor; `all`: all sensors, as one recording */
  readonly sensors?: 'one' | 'all';
  /** Sensors of one recording, each ``NAME=PATH``, the reference first; paths are within the imported path, if there is one. */
  readonly sensor?: readonly string[] | null;
  /** File in JSON with the mount ``T_frame_sensor`` of each sensor by name, 16 numbers by rows. */
  readonly extrinsics?: string | null;
  /** Seconds to add to the times of a sensor: ``NAME=SECONDS``, or ``NAME=auto`` to estimate them from motion that it and the reference see. */
  readonly clock_offset?: readonly string[] | null;
  /** ``auto``, ``viewpoint`` of PCD files, ``none``, or a file of poses, one line per frame. */
  readonly poses?: string | null;
  /** Match poses with times, and colour images, to frames by their order. */
  readonly by_order?: boolean;
  /** Leave out points without finite coordinates instead of refusing the files. */
  readonly drop_invalid?: boolean;
  /** Id of the project that the recording joins. */
  readonly project?: string;
  /** UUID of the job: a repeated call does not begin another job. */
  readonly id?: string | null;
}

/** Preview of an import with its uploaded files. */
export interface ImportPreview {
  /** Name that the recording would get. */
  readonly name: string;
  /** Format of the files. */
  readonly format: string;
  /** Format that people see. */
  readonly title: string;
  /** Number of frames; null: unknown before the whole is read. */
  readonly frames: number | null;
  /** Frames per second of playback. */
  readonly fps: number;
  /** Source of ``fps``. */
  readonly fps_from: string;
  /** Rule that orders the frames. */
  readonly order: string;
  /** Frame of each file, the first hundred. */
  readonly files: readonly FileFrame[];
  /** Points of the first frames. */
  readonly points: readonly PreviewedFrame[];
  /** Columns of the points. */
  readonly columns: readonly PreviewedColumn[];
  /** Topics of a bag. */
  readonly topics: readonly PreviewedTopic[];
  /** ``name`` of each camera with pictures. */
  readonly cameras: readonly (Readonly<Record<string, unknown>>)[];
  /** Sensors of a recording of several, the reference first. */
  readonly sensors: readonly PreviewedSensor[];
  /** Poses of the frames; null: none. */
  readonly poses: PreviewedPoses | null;
  /** Unit of the coordinates. */
  readonly units: UnitGuess;
  /** Axis that points up. */
  readonly up: string;
  /** Source of ``up``. */
  readonly up_from: string;
  /** The files contain labels. */
  readonly labels: boolean;
  /** Corrections of the request that take effect. */
  readonly corrections: Readonly<Record<string, unknown>>;
  /** Sentences about doubtful content. */
  readonly warnings: readonly string[];
  /** Id of the uploaded files, which are kept for an hour; null: files of the server. */
  readonly upload: string | null;
}

/** Result of an import of labels, or of its trial; lists have the first hundred entries. */
export interface ImportedLabels {
  /** Number of labelled points in the files. */
  readonly labelled: number;
  /** Number of points at the borders of masks, which stay as they are. */
  readonly doubtful: number;
  /** Frames with labels, each with its file. */
  readonly frames: readonly LabelledFrame[];
  /** All files that match a frame. */
  readonly files: readonly FileFrame[];
  /** Number of frames with labels. */
  readonly matched: number;
  /** Number of classes without a name. */
  readonly unknown: number;
  /** Numbers of classes without a name. */
  readonly unknown_classes: readonly number[];
  /** Number of frames without labels and of files without a frame. */
  readonly unmatched: number;
  /** Numbers of frames without labels. */
  readonly unmatched_frames: readonly number[];
  /** Files without a frame. */
  readonly unmatched_files: readonly string[];
  /** Number of labelled points, by id of the label. */
  readonly labels: Readonly<Record<string, number>>;
  /** Names of the new labels. */
  readonly new_labels: readonly string[];
  /** Number of new boxes. */
  readonly boxes: number;
  /** Number of poses of new boxes. */
  readonly box_poses: number;
  /** Number of poses that a label already has. */
  readonly box_poses_known: number;
  /** Objects whose sizes differ between frames: their box has the median size. */
  readonly boxes_resized: readonly string[];
  /** Number of boxes with a side of 0, which are left out. */
  readonly boxes_empty: number;
  /** Sentences about doubtful content. */
  readonly warnings: readonly string[];
  /** Names of locked labels that keep points which the files label otherwise. */
  readonly locked: readonly string[];
  /** UUID of the edit; null: none was made. */
  readonly edit: string | null;
  /** Number of points with a new label. */
  readonly changed: number;
  /** Reason why the files label nothing; empty: they label something. */
  readonly refused: string;
}

/** State and progress of a job. */
export interface Job {
  /** UUID of the job. */
  readonly id: string;
  /** Kind of work. `import`: reads files of points or labels; `tracking`: carries labels to other frames; `export`: writes files; `prediction`: applies a classifier, or finds people; `fitting`: fits boxes; `alignment`: aligns sensors */
  readonly kind: 'import' | 'tracking' | 'export' | 'prediction' | 'fitting' | 'alignment';
  /** Id of its recording; null: an import without one yet. */
  readonly sequence: string | null;
  /** State of the work; the last three are final. `queued`: waits for a worker; `running`: at work; `done`: ended with a result; `failed`: ended with an error; `cancelled`: ended by a person */
  readonly state: 'queued' | 'running' | 'done' | 'failed' | 'cancelled';
  /** Finished share, 0 to 1. */
  readonly progress: number;
  /** Sentence about the present step or the result; may be empty. */
  readonly message: string;
  /** Result of a job that is done, as its call describes it. */
  readonly result: Readonly<Record<string, unknown>> | null;
  /** Reason of a failure. */
  readonly error: string | null;
  /** Account that started it; null: the server. */
  readonly owner: string | null;
}

/** Agreement on a label, by name. */
export interface LabelAgreement {
  /** Name of the label or category. */
  readonly name: string;
  /** Intersection over union of its points, 0 to 1. */
  readonly iou: number;
  /** Number of its points in the first annotation. */
  readonly first: number;
  /** Number of its points in the second annotation. */
  readonly second: number;
  /** Number of its points in both annotations. */
  readonly both: number;
}

/** A label that differs between two versions. */
export interface LabelDifference {
  /** Id of the label. */
  readonly label: number;
  /** Name in the later version that has it. */
  readonly name: string;
  /** Kind of difference. `came`: the label was added; `went`: the label was removed; `changed`: the label has another name, category or colour */
  readonly kind: 'came' | 'went' | 'changed';
}

/** A frame with labels from a file. */
export interface LabelledFrame {
  /** Path of the file. */
  readonly file: string;
  /** Number of the frame. */
  readonly frame: number;
  /** Number of labelled points. */
  readonly points: number;
}

/** End of a log. */
export interface LogPosition {
  /** Number of the next record. */
  readonly next: number;
}

/** One record of a session's log; fields that its ``kind`` does not name are left out. */
export interface LogRecord {
  /** `stroke`: an edit (``id``, ``tool``, ``shape``, ``label``, ``frame``); `click` of the object tool (``shape`` positive or negative); `undo`, `redo` of the last edit (``id``); another `level` of its candidates; another `label`; `playback` (``action`` play, pause, step or seek; the ``frame`` it leads to); `pose` at 30 Hz (``head``, ``left``, ``right``); `frame_time` of the last second; `device` (``profile``), once a session; `phase` that begins. */
  readonly kind: 'stroke' | 'click' | 'undo' | 'redo' | 'level' | 'label' | 'playback' | 'pose' | 'frame_time' | 'device' | 'phase';
  /** Number of the step in which it was made. */
  readonly step: number;
  /** Milliseconds since the step began, by the page's monotonic clock. */
  readonly t: number;
  /** UUID of a stroke, an undo or a redo, which is that of its edit. */
  readonly id?: string;
  /** Tool of a stroke: paint, erase, delete or restore. */
  readonly tool?: string;
  /** Shape of a stroke, or ``positive`` and ``negative`` of a click. */
  readonly shape?: string;
  /** Id of the label. */
  readonly label?: number | null;
  /** Level of the object tool. */
  readonly level?: number | null;
  /** Frame of the recording. */
  readonly frame?: number | null;
  /** Action of playback. */
  readonly action?: string;
  /** Phase that begins: `navigation` (the view moves), `painting` (a trigger or button is held to label) or `waiting` (neither). */
  readonly phase?: 'navigation' | 'painting' | 'waiting' | null;
  /** Pose of the head; at the desk of the camera. */
  readonly head?: readonly [number, number, number, number, number, number, number] | null;
  /** Pose of the left hand or controller. */
  readonly left?: readonly [number, number, number, number, number, number, number] | null;
  /** Pose of the right hand or controller. */
  readonly right?: readonly [number, number, number, number, number, number, number] | null;
  /** Mean time of a picture in the last second, milliseconds. */
  readonly mean_ms?: number | null;
  /** Time that 95% of the last second's pictures kept, milliseconds. */
  readonly p95_ms?: number | null;
  /** Pictures of the last second that were late by more than half a period. */
  readonly dropped?: number | null;
  /** Properties of the device, such as ``agent``, ``gpu``, ``controllers``, ``rate``. */
  readonly profile?: Readonly<Record<string, string>> | null;
}

/** Consecutive records of a log. */
export interface LogRecords {
  /** Number of the first of them; the first record of a session has 0. */
  readonly first: number;
  /** The records in order. */
  readonly records: readonly LogRecord[];
}

/** Facts of a recording; a damaged one may have only its id. */
export interface Manifest {
  /** Name in URLs; another recording may get it after a deletion. */
  readonly id: string;
  /** Text that people see. */
  readonly name: string;
  /** Number of frames. */
  readonly frames: number;
  /** Frames per second of playback. */
  readonly fps: number;
  /** Number of points of each frame. */
  readonly points: readonly number[];
  /** Box around the points of all frames. */
  readonly bounds: Bounds;
  /** Fields of the points that at least one frame has, such as ``xyz`` and ``rgb``. */
  readonly fields: readonly string[];
  /** Number of edits since the import; every edit adds one. */
  readonly revision: number;
  /** Local coordinates = source coordinates - ``shift``, metres. */
  readonly shift: readonly [number, number, number];
  /** Transform from local coordinates to the floor of the page, y up, row by row. */
  readonly room: readonly number[];
  /** Greatest error of a streamed coordinate, metres per axis. */
  readonly position_error: number;
  /** Number of invalid points of each frame that the import left out. */
  readonly dropped: readonly number[];
  /** Frames are octrees of chunks, which a viewer loads by detail. */
  readonly large: boolean;
  /** Name of the imported file or folder. */
  readonly source: string;
  /** Time of the import. */
  readonly created: string | null;
  /** Time of its last edit, or else of its import. */
  readonly changed: string | null;
  /** Number of frames with labelled points. */
  readonly labelled: number;
  /** Number of labels. */
  readonly labels: number;
  /** Number of labels that have points in some frame. */
  readonly labels_used: number;
  /** Reason why it cannot be opened; null: intact. */
  readonly damaged: string | null;
  /** Reason why the labels in its files were not imported; null: imported, or none. */
  readonly labels_missing: string | null;
  /** Id of its project. */
  readonly project: string;
  /** Id of the recording of which this is one person's copy; only for reviewers. */
  readonly copy_of: string | null;
  /** Id of this import; never given to another one. */
  readonly identity: string | null;
  /** Time of its deletion; null: not deleted. */
  readonly deleted: string | null;
  /** End of the time in which it can be restored. */
  readonly until: string | null;
  /** Its sensors, if it has several. */
  readonly sensors: readonly Sensor[];
}

/** Edit that labels points from masks. */
export interface MaskEdit {
  /** UUID of the edit. */
  readonly edit: string;
  /** Number of points with a new label, provenance or deletion. */
  readonly changed: number;
  /** Revision of the recording after the edit. */
  readonly revision: number;
  /** Number of points with a value in the masks that has a label or class. */
  readonly seen: number;
  /** Number of points that keep their label because they are near a border of a mask or cameras disagree. */
  readonly doubt: number;
}

/** Placement of a tracked label's points. */
export interface Moving {
  /** Id of the label. */
  readonly label: number;
  /** Transform to the shown frame by the label's track, source coordinates. */
  readonly T_shown_frame: readonly number[];
}

/** Tasks to create. */
export interface NewTasks {
  /** Ids of recordings; null: all of the project. */
  readonly recordings?: readonly string[] | null;
  /** Frames ``I:J`` of each recording; null: all frames. */
  readonly frames?: string | null;
  /** Number of frames of a task; null: one task for all frames. */
  readonly every?: number | null;
  /** Account that the tasks are reserved for; empty: any. */
  readonly assignee?: string;
  /** Number of people who label the same frames, each in a separate copy. */
  readonly people?: number;
  /** The existing labels are hidden, and are ground truth for scores. */
  readonly truth?: boolean;
  /** UUID of the call: a repeated call creates no other tasks. */
  readonly id?: string | null;
}

/** A new token with its secret; no other answer contains the secret. */
export interface NewToken {
  /** Id for its revocation. */
  readonly id: string;
  /** Role that it gives. `viewer`: sees recordings and labels; `annotator`: changes labels; `reviewer`: accepts and rejects labels; `manager`: manages recordings, projects and accounts; `admin`: manages the server */
  readonly role: 'viewer' | 'annotator' | 'reviewer' | 'manager' | 'admin';
  /** Name of the account. */
  readonly name: string;
  /** Time of its creation. */
  readonly created: string;
  /** End of its validity; null: never. */
  readonly expires: string | null;
  /** Time of its revocation; null: not revoked. */
  readonly revoked: string | null;
  /** It gives access now. */
  readonly valid: boolean;
  /** Id of the account, which is the author of its edits. */
  readonly account: string;
  /** The secret. */
  readonly token: string;
}

/** Categories for labels. */
export interface OfferedCategories {
  /** The project selects them: labels get no other category. */
  readonly selected: boolean;
  /** Their names, by number. */
  readonly names: readonly string[];
}

/** Keyboard shortcuts of the caller. */
export interface OwnKeys {
  /** Keys by the text of the command; null: the caller has never chosen any. */
  readonly keys: Readonly<Record<string, string>> | null;
}

/** A palette as a file. */
export interface Palette {
  /** Its labels, in order. */
  readonly labels: readonly PaletteLabel[];
}

/** A label without its id; other fields of an exported ``palette.json`` are ignored. */
export interface PaletteLabel {
  /** Text that people see. */
  readonly name: string;
  /** Name of its class; empty: none. */
  readonly category: string;
  /** ``#rrggbb``; null: the default colour of its id. */
  readonly color: string | null;
}

/** A participant and the current step. */
export interface Participant {
  /** Number in the study, from 1. */
  readonly number: number;
  /** Names of the participant's conditions in order. */
  readonly conditions: readonly string[];
  /** `waiting` (has not begun), `running`, `paused` by the experimenter, or `done`. */
  readonly state: 'waiting' | 'running' | 'paused' | 'done';
  /** Number of the current step, from 0. */
  readonly step: number;
  /** Number of steps. */
  readonly count: number;
  /** Kind of the current step: `consent`, `instructions`, `practice`, `task`, `questionnaire`, `pause`, or `done`. */
  readonly kind: 'consent' | 'instructions' | 'practice' | 'task' | 'questionnaire' | 'pause' | 'done';
  /** Task of the current step; null: none. */
  readonly task: string | null;
  /** Id of the copy that the current step shows, to follow the session; null: none. */
  readonly sequence: string | null;
  /** Mean IoU of the labels of the current task; null: no task. */
  readonly iou: number | null;
  /** Number of records in the log. */
  readonly records: number;
  /** Secret code, only in the answer that adds the participant: only its digest is stored. */
  readonly code: string;
  /** Address to open, with the code. */
  readonly link: string;
}

/** One line of the history. */
export interface PastEdit {
  /** UUID of the edit. */
  readonly id: string;
  /** Revision of the recording after the edit. */
  readonly revision: number;
  /** Name of the person or token. */
  readonly author: string;
  /** Time of the commit. */
  readonly time: string;
  /** Kind of change, such as ``paint``, ``tracking`` or ``undo``. */
  readonly kind: string;
  /** Sentence about the change. */
  readonly summary: string;
  /** Number of changed points. */
  readonly points: number;
  /** Numbers of the changed frames. */
  readonly frames: readonly number[];
  /** Its author has undone and not redone it. */
  readonly undone: boolean;
}

/** Figures of a person. */
export interface PersonFigures {
  /** Name of the person. */
  readonly name: string;
  /** Hours of editing. */
  readonly hours: number;
  /** Number of edits. */
  readonly edits: number;
  /** Number of points that their strokes changed. */
  readonly points: number;
}

/** Points of a person in a frame. */
export interface PersonPoints {
  /** Number of the frame. */
  readonly frame: number;
  /** Mean probability of the person's points, 0 to 1. */
  readonly score: number;
  /** Number of the person's points. */
  readonly points: number;
  /** Runs of these points: first number and length. */
  readonly runs: readonly (readonly [number, number])[];
}

/** A doubtful place, where a label teaches most. */
export interface Place {
  /** Id of the recording. */
  readonly sequence: string;
  /** Number of the frame. */
  readonly frame: number;
  /** Point on a surface, source coordinates, metres. */
  readonly centre: readonly [number, number, number];
  /** Radius of a stroke there, metres. */
  readonly radius: number;
  /** Number of points in the piece. */
  readonly points: number;
  /** Runs of these points: first number and length. */
  readonly runs: readonly (readonly [number, number])[];
  /** Its two most likely classes, the likelier first. */
  readonly classes: readonly [string, string];
  /** Doubt between them, 0 to 1. */
  readonly doubt: number;
}

/** Placement of a frame over the shown one. */
export interface Placement {
  /** Number of the frame. */
  readonly frame: number;
  /** Transform to the shown frame by the poses of the recording, source coordinates. */
  readonly T_shown_frame: readonly number[];
  /** Labels with points that their tracks place elsewhere. */
  readonly moving: readonly Moving[];
}

/** A column of the points. */
export interface PreviewedColumn {
  /** Name in the file. */
  readonly name: string;
  /** Meaning, such as ``x``; empty: left out. */
  readonly meaning: string;
}

/** Points of a frame that a preview has read. */
export interface PreviewedFrame {
  /** Number of points. */
  readonly points: number;
  /** Number of points without a position, which are left out. */
  readonly left_out: number;
}

/** Poses of the frames. */
export interface PreviewedPoses {
  /** Place where they were found. */
  readonly source: string;
  /** Frames agree better with them than without; null: not measured. */
  readonly agree: boolean | null;
}

/** One of several sensors of a recording, and the joining of its frames by time. */
export interface PreviewedSensor {
  /** Name of the sensor. */
  readonly name: string;
  /** Type of the sensor. `depth`: a depth camera; `spinning`: a lidar that turns; `solid-state`: a lidar without a turning head; `radar`: a radar; `unknown`: the files do not tell */
  readonly type: 'depth' | 'spinning' | 'solid-state' | 'radar' | 'unknown';
  /** Number of its frames that are joined with frames of the reference. */
  readonly joined: number;
  /** Number of its other frames. */
  readonly left_out: number;
  /** Median seconds between frames that are joined; null: they are joined in their order. */
  readonly apart: number | null;
}

/** A topic of a bag. */
export interface PreviewedTopic {
  /** Name of the topic. */
  readonly name: string;
  /** Type of its messages. */
  readonly type: string;
  /** Number of its messages. */
  readonly messages: number;
  /** Its messages are point clouds. */
  readonly clouds: boolean;
  /** The import reads it. */
  readonly read: boolean;
}

/** A project as the caller sees it. */
export interface ProjectInfo {
  /** Name in URLs. */
  readonly id: string;
  /** Text that people see. */
  readonly name: string;
  /** Time of its creation. */
  readonly created: string;
  /** Role of the caller in it. `viewer`: sees recordings and labels; `annotator`: changes labels; `reviewer`: accepts and rejects labels; `manager`: manages recordings, projects and accounts; `admin`: manages the server */
  readonly role: 'viewer' | 'annotator' | 'reviewer' | 'manager' | 'admin';
  /** Role in the project by account; empty: every account has its role in the workspace. */
  readonly roles: Readonly<Record<string, 'viewer' | 'annotator' | 'reviewer' | 'manager' | 'admin'>>;
  /** Numbers of the selected categories; null: all categories. */
  readonly categories: readonly number[] | null;
  /** Ids of its recordings. */
  readonly recordings: readonly string[];
  /** Number of its tasks in each state. */
  readonly tasks: Readonly<Partial<Record<'open' | 'taken' | 'done' | 'review' | 'accepted' | 'returned', number>>>;
  /** Number of tasks in each state, by the name of the assignee; empty name: not assigned. */
  readonly people: Readonly<Record<string, Readonly<Partial<Record<'open' | 'taken' | 'done' | 'review' | 'accepted' | 'returned', number>>>>>;
}

/** One item of a questionnaire: a scale. */
export interface QuestionItem {
  /** Statement or question. */
  readonly text: string;
  /** Text at the low end of the scale. */
  readonly low: string;
  /** Text at the high end of the scale. */
  readonly high: string;
  /** Number of positions of the scale; answers are 1 to ``steps``. */
  readonly steps: number;
  /** A high answer counts as a low one. */
  readonly reversed: boolean;
}

/** Items that are answered after each condition or at the end of the study. */
export interface Questionnaire {
  /** Name in results. */
  readonly name: string;
  /** Published items if there are no others: `sus` System Usability Scale, `tlx` raw NASA-TLX, `own` none. The score is the mean of the answers, 0 to 100, with reversed items turned. */
  readonly scoring: 'sus' | 'tlx' | 'own';
  /** Heading of the page; empty: the name. */
  readonly title: string;
  /** The items in order. */
  readonly items: readonly QuestionItem[];
  /** Time of the questionnaire: after each `condition`, or after the `study`. */
  readonly after: 'condition' | 'study';
}

/** The review of a recording. */
export interface ReviewOverview {
  /** Number of frames in each state. */
  readonly counts: Readonly<Partial<Record<'open' | 'review' | 'accepted' | 'rejected', number>>>;
  /** Runs of reviewed frames, by label and frame. */
  readonly frames: readonly Standing[];
  /** Labels that were reviewed as a whole. */
  readonly labels: readonly Standing[];
  /** Names of people who may be assigned: editors, reviewers and assignees. */
  readonly people: readonly string[];
}

/** Values for a range of frames, or for a label in all frames. */
export interface ReviewPatch {
  /** New note; empty: removes the note. */
  readonly note?: string | null;
  /** Position that the note is pinned to, source coordinates, metres. */
  readonly place?: readonly [number, number, number] | null;
  /** Account that the work is assigned to; empty: any. */
  readonly assignee?: string | null;
  /** New state; accepting and rejecting need the role reviewer.  `open`: not reviewed; `review`: waits for a reviewer; `accepted`: accepted by a reviewer; `rejected`: rejected by a reviewer */
  readonly state?: 'open' | 'review' | 'accepted' | 'rejected' | null;
  /** Id of a label to review instead of the frames themselves. */
  readonly label?: number | null;
  /** First frame; null: the label as a whole. */
  readonly first?: number | null;
  /** Last frame, included. */
  readonly last?: number | null;
}

/** Work of a person on frames with ground truth. */
export interface Score {
  /** Name of the person. */
  readonly person: string;
  /** Number of compared frames. */
  readonly frames: number;
  /** Mean IoU of classes, 0 to 1; null: no labels. */
  readonly miou: number | null;
  /** Number of objects of the ground truth that the person labelled. */
  readonly found: number;
  /** Number of objects of the ground truth that the person missed. */
  readonly missed: number;
  /** Number of objects that the ground truth does not have. */
  readonly added: number;
}

/** A new webhook; no other answer contains the secret. */
export interface SecretWebhook {
  /** Id in URLs. */
  readonly id: string;
  /** Address that receives the events. */
  readonly url: string;
  /** Events that are sent. */
  readonly topics: readonly ('task' | 'labels' | 'job')[];
  /** Time of its creation. */
  readonly created: string;
  /** Time of the next attempt while the receiver is away; null: it answers. */
  readonly paused_until: string | null;
  /** Secret that signs its events. */
  readonly secret: string;
}

/** One of several sensors of a recording. */
export interface Sensor {
  /** Its name in the files, or the one that its import gave it. */
  readonly name: string;
  /** Its kind. `depth`: a depth camera; `spinning`: a lidar that turns; `solid-state`: a lidar without a turning head; `radar`: a radar; `unknown`: the files do not tell */
  readonly type: 'depth' | 'spinning' | 'solid-state' | 'radar' | 'unknown';
  /** Transform from its coordinates to those of a frame, corrections included: one for all frames, or one for each. */
  readonly mounts: readonly (readonly number[])[];
  /** Time of its measurement in each frame, seconds; null: unknown. */
  readonly times: readonly (number | null)[];
  /** Number of its points in each frame. */
  readonly points: readonly number[];
  /** Part of the mounts that corrects the files': the identity, or a small motion. */
  readonly correction: readonly number[];
}

/** A version of a project's labels. */
export interface Snapshot {
  /** Name in URLs. */
  readonly id: string;
  /** Text that people see. */
  readonly name: string;
  /** Time of the version. */
  readonly created: string;
  /** Name of the person who created it. */
  readonly author: string;
  /** Revision of each recording at its time, by id. */
  readonly recordings: Readonly<Record<string, number>>;
}

/** Result of the division of a label. */
export interface Split {
  /** UUID of the edit. */
  readonly edit: string;
  /** Number of points with a new label, provenance or deletion. */
  readonly changed: number;
  /** Revision of the recording after the edit. */
  readonly revision: number;
  /** Ids of the new labels, the largest first. */
  readonly labels: readonly number[];
  /** Distance between parts, metres. */
  readonly gap: number;
}

/** Review state of frames, or of a label. */
export interface Standing {
  /** First frame; null: the label as a whole. */
  readonly first: number | null;
  /** Last frame, included. */
  readonly last: number | null;
  /** Id of the label; null: the frames themselves. */
  readonly label: number | null;
  /** Current state. `open`: not reviewed; `review`: waits for a reviewer; `accepted`: accepted by a reviewer; `rejected`: rejected by a reviewer */
  readonly state: 'open' | 'review' | 'accepted' | 'rejected';
  /** Note of a person; may be empty. */
  readonly note: string;
  /** Position of the note, source coordinates, metres. */
  readonly place: readonly [number, number, number] | null;
  /** Name of the person that the frames are assigned to, or empty. */
  readonly assignee: string;
  /** Name of the person who set the state or note, or empty. */
  readonly by: string;
  /** Time of the last state or note. */
  readonly at: string | null;
  /** Labels have changed since the decision. */
  readonly changed: boolean;
}

/** Figures of a project, from its edits. */
export interface Statistics {
  /** Number of recordings. */
  readonly recordings: number;
  /** Number of frames with labelled points. */
  readonly labelled_frames: number;
  /** Number of labelled points. */
  readonly points: number;
  /** Number of labels with points. */
  readonly objects: number;
  /** Hours of editing. */
  readonly hours: number;
  /** Figures by class, the most points first. */
  readonly classes: readonly ClassFigures[];
  /** Figures by person, the most hours first. */
  readonly people: readonly PersonFigures[];
}

/** A study, as its file ``studies/ID.yaml`` in the workspace describes it. */
export interface Study {
  /** Title that participants see. */
  readonly title: string;
  /** Text to which participants agree first; empty: no such step. */
  readonly consent: string;
  /** Ways of labelling to compare. */
  readonly conditions: readonly Condition[];
  /** Conditions of a participant: all (`within`) or one (`between`). */
  readonly design: 'within' | 'between';
  /** Order of conditions: a balanced `latin` square by the participants' numbers, or `random`. */
  readonly order: 'latin' | 'random';
  /** Seed of the random order and of the bootstrap. */
  readonly seed: number;
  /** Tasks of each condition, in order; practice comes first. */
  readonly tasks: readonly StudyTask[];
  /** Questionnaires in order. */
  readonly questionnaires: readonly Questionnaire[];
}

/** A study and the number of its participants. */
export interface StudyInfo {
  /** Name in URLs. */
  readonly id: string;
  /** The study. */
  readonly study: Study;
  /** The file of the study, YAML. */
  readonly text: string;
  /** Number of participants. */
  readonly participants: number;
  /** Number of participants that have finished. */
  readonly done: number;
}

/** A step of a participant. */
export interface StudyStep {
  /** Kind of the step: `consent` to agree to; `instructions` of a condition or task; `practice`, a task that is not measured; a `task`; a `questionnaire`; `pause` by the experimenter; `done`. */
  readonly kind: 'consent' | 'instructions' | 'practice' | 'task' | 'questionnaire' | 'pause' | 'done';
  /** Text to show: of the consent, the condition or the task. */
  readonly text: string;
  /** Condition of the step; null: none. */
  readonly condition: Condition | null;
  /** Task of the step; null: none. */
  readonly task: StudyTask | null;
  /** Questionnaire of the step; null: none. */
  readonly questionnaire: Questionnaire | null;
  /** Title of the study. */
  readonly title: string;
  /** Number of the step, from 0. */
  readonly number: number;
  /** Number of steps. */
  readonly count: number;
  /** Id of the participant's copy of the recording; null: no task. */
  readonly sequence: string | null;
  /** First frame of the task. */
  readonly start: number;
  /** Frame after the last one of the task. */
  readonly stop: number;
  /** Ids of the labels to reach, in the palette of ``sequence``. */
  readonly labels: readonly number[];
  /** Seconds until the time limit; null: none. */
  readonly time_left_s: number | null;
  /** Seconds since the step began, without pauses; records count from there. */
  readonly elapsed_s: number;
  /** The task may end: its time limit or its ``target_iou`` is reached. */
  readonly reached: boolean;
  /** Number of the next record of the log, from 0. */
  readonly records: number;
}

/** Labels to reach in some frames of a recording. */
export interface StudyTask {
  /** Name in results. */
  readonly name: string;
  /** Id of the recording; each participant labels a copy of it without labels. */
  readonly recording: string;
  /** Generated sample that becomes the recording if it does not exist; empty: none. */
  readonly sample: string;
  /** Frames ``I:J`` to label, J not included. */
  readonly frames: string;
  /** Names of the labels to reach, of the recording's palette. */
  readonly labels: readonly string[];
  /** Id of a snapshot with the ground truth; empty: the current labels of the recording. */
  readonly truth: string;
  /** Time after which the task ends, seconds without pauses; null: none. */
  readonly time_limit_s: number | null;
  /** Event that ends the task: the participant's `button`, the `time` limit, or `iou`, that is ``target_iou``. The time limit ends every task. */
  readonly stop: 'button' | 'time' | 'iou';
  /** Mean IoU of the labels at which a task with ``stop`` iou ends. */
  readonly target_iou: number;
  /** Text before the task. */
  readonly instructions: string;
  /** Picture beside the instructions, as a data URL; empty: a thumbnail of the recording. */
  readonly picture: string;
  /** The task is practice: it comes first in each condition and is not in the results. */
  readonly practice: boolean;
}

/** Frames of a recording to label. */
export interface Task {
  /** Number of the task in its project. */
  readonly number: number;
  /** Id of the recording. */
  readonly sequence: string;
  /** First frame. */
  readonly first: number;
  /** Last frame, included. */
  readonly last: number;
  /** State of the work. `open`: not assigned; `taken`: being labelled; `done`: labelled, waits for a review; `review`: being reviewed; `accepted`: accepted by a reviewer; `returned`: to be labelled again */
  readonly state: 'open' | 'taken' | 'done' | 'review' | 'accepted' | 'returned';
  /** Name of the annotator, or empty. */
  readonly assignee: string;
  /** Name of the reviewer, or empty. */
  readonly reviewer: string;
  /** Note of a reviewer; may be empty. */
  readonly note: string;
  /** Frame of ``place``. */
  readonly frame: number | null;
  /** Position of the note, source coordinates, metres. */
  readonly place: readonly [number, number, number] | null;
  /** Time of its creation. */
  readonly created: string;
  /** Time of its last change. */
  readonly changed: string;
}

/** A change of a task. */
export interface TaskEvent {
  /** Time of the change. */
  readonly at: string;
  /** Name of the person who made it. */
  readonly by: string;
  /** State after the change. `open`: not assigned; `taken`: being labelled; `done`: labelled, waits for a review; `review`: being reviewed; `accepted`: accepted by a reviewer; `returned`: to be labelled again */
  readonly state: 'open' | 'taken' | 'done' | 'review' | 'accepted' | 'returned';
  /** Name of the annotator after the change, or empty. */
  readonly assignee: string;
  /** Note after the change; may be empty. */
  readonly note: string;
}

/** Values to set; missing fields and null do not change. */
export interface TaskPatch {
  /** New note; empty: removes the note. */
  readonly note?: string | null;
  /** Position that the note is pinned to, source coordinates, metres. */
  readonly place?: readonly [number, number, number] | null;
  /** Account that the work is assigned to; empty: any. */
  readonly assignee?: string | null;
  /** New state.  `open`: not assigned; `taken`: being labelled; `done`: labelled, waits for a review; `review`: being reviewed; `accepted`: accepted by a reviewer; `returned`: to be labelled again */
  readonly state?: 'open' | 'taken' | 'done' | 'review' | 'accepted' | 'returned' | null;
  /** Frame of ``place``. */
  readonly frame?: number | null;
}

/** The classes of a workspace and the attributes of boxes; can be put into another workspace. */
export interface Taxonomy {
  /** All classes, by number. */
  readonly categories: readonly Category[];
  /** Attributes of boxes, in the order of the page. */
  readonly attributes: readonly BoxAttribute[];
}

/** A token without its secret. */
export interface Token {
  /** Id for its revocation. */
  readonly id: string;
  /** Role that it gives. `viewer`: sees recordings and labels; `annotator`: changes labels; `reviewer`: accepts and rejects labels; `manager`: manages recordings, projects and accounts; `admin`: manages the server */
  readonly role: 'viewer' | 'annotator' | 'reviewer' | 'manager' | 'admin';
  /** Name of the account. */
  readonly name: string;
  /** Time of its creation. */
  readonly created: string;
  /** End of its validity; null: never. */
  readonly expires: string | null;
  /** Time of its revocation; null: not revoked. */
  readonly revoked: string | null;
  /** It gives access now. */
  readonly valid: boolean;
}

/** Estimated unit of the files. */
export interface UnitGuess {
  /** Name of the unit. */
  readonly name: string;
  /** Metres per unit. */
  readonly scale: number;
  /** Width of the middle 96 % of the first frame's points along each axis, in units. */
  readonly extent: readonly [number, number, number];
}

/** An address that receives events. */
export interface Webhook {
  /** Id in URLs. */
  readonly id: string;
  /** Address that receives the events. */
  readonly url: string;
  /** Events that are sent. */
  readonly topics: readonly ('task' | 'labels' | 'job')[];
  /** Time of its creation. */
  readonly created: string;
  /** Time of the next attempt while the receiver is away; null: it answers. */
  readonly paused_until: string | null;
}
