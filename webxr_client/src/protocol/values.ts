// Generated from values/ of server/pointbrush by
// `python -m pointbrush.streaming.typescript --write`.
// Do not edit: a stale file fails the tests.

/** Labels of a frame that a person accepts. */
export interface Acceptance {
  /** Ids of the labels. */
  readonly labels: readonly number[];
  /** UUID of the edit, which is applied once. */
  readonly id?: string | null;
}

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

/** A classifier to apply to a recording. */
export interface Application {
  /** Id of the classifier. */
  readonly classifier?: string;
  /** Frames ``I:J``; empty: all frames. */
  readonly frames?: string;
  /** Minimum confidence of points to label, 0 to 1; null: as measured in held-out places. */
  readonly above?: number | null;
  /** UUID of the job and of its edit: a repeated call does not begin another job. */
  readonly id?: string | null;
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

/** Fields of a box: one size, and a pose in each of its frames. */
export interface BoxFields {
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

/** Changes of a box; missing fields do not change it. */
export interface BoxPatch {
  /** Id of its new label. */
  readonly label?: number | null;
  /** New length, width and height, metres. */
  readonly size?: readonly [number, number, number] | null;
  /** Changes of poses by frame; null removes one, others do not change. */
  readonly poses?: Readonly<Record<string, PosePatch | null>>;
  /** Attributes by name; null removes one, others do not change. */
  readonly attributes?: Readonly<Record<string, string | number | boolean | null>>;
  /** New origin of the box.  `fitted`: fitted to the label's points; `drawn`: drawn or moved by a person; `imported`: read from a file */
  readonly provenance?: 'fitted' | 'drawn' | 'imported' | null;
  /** False: the front of the object may also be at the opposite end of the box. */
  readonly heading_known?: boolean | null;
  /** UUID of the edit, which is applied once. */
  readonly edit?: string | null;
}

/** Frames in which to label the points inside a box. */
export interface BoxPoints {
  /** Frames ``I:J``; null: all frames with a pose of the box. */
  readonly frames?: string | null;
  /** Points with another label keep it. */
  readonly only_unlabeled?: boolean;
  /** UUID of the edit, which is applied once. */
  readonly edit?: string | null;
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

/** The boxes of a recording. */
export interface Boxes {
  /** Boxes by id, with all their poses. */
  readonly boxes: readonly Box[];
  /** Revision of the recording. */
  readonly revision: number;
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

/** Points that a click may select. */
export interface Candidate {
  /** Id for the ``candidate`` of a stroke of shape ``object``. */
  readonly id: string;
  /** Size of the part: 0 the smallest. */
  readonly level: number;
  /** Estimated quality as an object, 0 to 1. */
  readonly score: number;
  /** Number of its points. */
  readonly points: number;
  /** Runs of its points in source order: first number and length. */
  readonly runs: readonly (readonly [number, number])[];
}

/** At most six candidates, from part to group. */
export interface Candidates {
  /** The candidates, the smallest part first. */
  readonly candidates: readonly Candidate[];
  /** Index of the one to show first. */
  readonly first: number;
  /** The whole frame is prepared; else candidates come from points near the clicks. */
  readonly ready: boolean;
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

/** Labels to remove from their points. */
export interface Clearing {
  /** Ids of the labels. */
  readonly labels: readonly number[];
  /** Last frame of the range, included; null: only this frame. */
  readonly stop?: number | null;
  /** UUID of the edit, which is applied once. */
  readonly id?: string | null;
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

/** Labels to write from copies into their recording. */
export interface CopyMerge {
  /** Id of the recording. */
  readonly sequence: string;
  /** Id of a copy, or ``majority`` of at least three people. */
  readonly take?: string;
  /** Points to merge; null: all points of submitted frames. */
  readonly region?: Region | null;
  /** UUID of the edit, which is applied once. */
  readonly id?: string | null;
}

/** Labels to copy from another frame. */
export interface Copying {
  /** Ids of the labels. */
  readonly labels: readonly number[];
  /** Number of the frame that has the labels. */
  readonly source: number;
  /** UUID of the edit, which is applied once. */
  readonly id?: string | null;
}

/** A line of the review's history; null: not set by the decision. */
export interface Decision {
  /** First frame; null: the label as a whole. */
  readonly first: number | null;
  /** Last frame, included. */
  readonly last: number | null;
  /** Id of the label; null: the frames themselves. */
  readonly label: number | null;
  /** State that was set.  `open`: not reviewed; `review`: waits for a reviewer; `accepted`: accepted by a reviewer; `rejected`: rejected by a reviewer */
  readonly state: 'open' | 'review' | 'accepted' | 'rejected' | null;
  /** Note that was set; empty: removed. */
  readonly note: string | null;
  /** Position of the note, source coordinates, metres. */
  readonly place: readonly [number, number, number] | null;
  /** Account that the frames were assigned to; empty: not assigned. */
  readonly assignee: string | null;
  /** Name of the person who decided. */
  readonly by: string;
  /** Time of the decision. */
  readonly at: string;
  /** Revision of the recording that was reviewed. */
  readonly revision: number;
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

/** Rule that divides a label's points in a frame into parts. */
export interface Division {
  /** Number of the frame. */
  readonly frame: number;
  /** Metres between parts; null: more than the spacing of the points. */
  readonly gap?: number | null;
  /** Least points of a part; smaller parts stay with the label. */
  readonly least?: number;
}

/** An answer to a doubt. */
export interface DoubtAnswer {
  /** Id of the classifier. */
  readonly classifier: string;
  /** The place that was asked about. */
  readonly place: DoubtPlace;
  /** Id of the label to paint; null: none of the classes, or skipped. */
  readonly class?: number | null;
  /** Ask no more about the place, but predict it. */
  readonly skip?: boolean;
}

/** A place as ``GET …/doubt`` lists it. */
export interface DoubtPlace {
  /** Number of the frame. */
  readonly frame: number;
  /** Point on a surface, source coordinates, metres. */
  readonly centre: readonly [number, number, number];
  /** Radius of the place, metres. */
  readonly radius: number;
}

/** Result of an edit, which is durable. */
export interface Edit {
  /** UUID of the edit. */
  readonly edit: string;
  /** Number of points with a new label, provenance or deletion. */
  readonly changed: number;
  /** Revision of the recording after the edit. */
  readonly revision: number;
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

/** Edits and tracking doubts after a revision, and jobs. */
export interface Events {
  /** Revision of the last edit: the next call's ``after``. */
  readonly revision: number;
  /** Digest of the jobs: the next call's ``jobs_seen``. */
  readonly jobs_seen: string;
  /** Edits after the revision, the oldest first. */
  readonly edits: readonly PastEdit[];
  /** Doubtful tracks in frames that these edits changed. */
  readonly doubts: readonly Track[];
  /** Jobs of the recording, the newest first; empty if none has changed. */
  readonly jobs: readonly Job[];
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

/** A folder on the server; each file or folder in it is a recording. */
export interface FolderImport {
  /** Path of the folder, below one of the allowed folders. */
  readonly path: string;
  /** Frames per second of playback; null: as found in the files. */
  readonly fps?: number | null;
}

/** A folder on the server. */
export interface FolderRequest {
  /** Path of the folder, below one of the allowed folders. */
  readonly path: string;
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

/** Values to set; missing fields and null do not change. */
export interface FrameReviewPatch {
  /** New state; accepting and rejecting need the role reviewer.  `open`: not reviewed; `review`: waits for a reviewer; `accepted`: accepted by a reviewer; `rejected`: rejected by a reviewer */
  readonly state?: 'open' | 'review' | 'accepted' | 'rejected' | null;
  /** New note; empty: removes the note. */
  readonly note?: string | null;
  /** Position that the note is pinned to, source coordinates, metres. */
  readonly place?: readonly [number, number, number] | null;
  /** Account that the frames are assigned to; empty: not assigned. */
  readonly assignee?: string | null;
  /** Id of a label to review instead of the frames themselves. */
  readonly label?: number | null;
}

/** A check that can begin. */
export interface HeadsetCheck {
  /** Id of the recording to try the controls in, which no list contains. */
  readonly sequence: string;
}

/** The server is up. */
export interface Health {
  /** State of the server. `ok`: the server answers */
  readonly status: 'ok';
  /** Version of the server. */
  readonly version: string;
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
  /** Meaning of each column of text files, ``-`` to skip one; also one text with commas. */
  readonly columns?: readonly string[] | null;
  /** Separator of the columns: a name such as ``semicolon``, or one character. */
  readonly delimiter?: string | null;
  /** Numbers in text files have a decimal comma. */
  readonly decimal_comma?: boolean | null;
  /** Metres per unit of the coordinates. */
  readonly scale?: number | null;
  /** Axis of the coordinates that points up, such as ``z`` or ``-y``. */
  readonly up?: string | null;
  /** Topic of a bag to read. */
  readonly topic?: string | null;
  /** ``auto``, ``none``, or the path of a file of poses. */
  readonly poses?: string | null;
  /** Match files beside the frames by their order instead of their names. */
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
  /** Frame of each file: ``file`` and ``frame``, the first hundred. */
  readonly files: readonly (Readonly<Record<string, unknown>>)[];
  /** ``points`` and points ``left_out`` of the first frames. */
  readonly points: readonly (Readonly<Record<string, number>>)[];
  /** ``name`` and ``meaning`` of each column. */
  readonly columns: readonly (Readonly<Record<string, string>>)[];
  /** ``name``, ``type`` and number of ``messages`` of each topic of a bag. */
  readonly topics: readonly (Readonly<Record<string, unknown>>)[];
  /** ``name`` of each camera with pictures. */
  readonly cameras: readonly (Readonly<Record<string, unknown>>)[];
  /** ``source`` of the poses, and whether frames ``agree`` by them; null: none. */
  readonly poses: Readonly<Record<string, unknown>> | null;
  /** ``name`` of the unit, its ``scale`` in metres, and the ``extent`` of the points. */
  readonly units: Readonly<Record<string, unknown>>;
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

/** Files to import that the server can already read. */
export interface ImportRequest {
  /** Name of the recording; null: of the file or folder. */
  readonly name?: string | null;
  /** Frames per second of playback, at most 1000. */
  readonly fps?: number | null;
  /** Format of the files, such as ``ply``; null: detected. */
  readonly format?: string | null;
  /** Meaning of each column of text files, ``-`` to skip one; also one text with commas. */
  readonly columns?: readonly string[] | null;
  /** Separator of the columns: a name such as ``semicolon``, or one character. */
  readonly delimiter?: string | null;
  /** Numbers in text files have a decimal comma. */
  readonly decimal_comma?: boolean | null;
  /** Metres per unit of the coordinates. */
  readonly scale?: number | null;
  /** Axis of the coordinates that points up, such as ``z`` or ``-y``. */
  readonly up?: string | null;
  /** Topic of a bag to read. */
  readonly topic?: string | null;
  /** ``auto``, ``none``, or the path of a file of poses. */
  readonly poses?: string | null;
  /** Match files beside the frames by their order instead of their names. */
  readonly by_order?: boolean;
  /** Leave out points without finite coordinates instead of refusing the files. */
  readonly drop_invalid?: boolean;
  /** Id of the project that the recording joins. */
  readonly project?: string;
  /** UUID of the job: a repeated call does not begin another job. */
  readonly id?: string | null;
  /** Path on the server, below one of its allowed folders; or ``upload``. */
  readonly path?: string | null;
  /** Id of files that were uploaded for a preview; or ``path``. */
  readonly upload?: string | null;
}

/** State and progress of a job. */
export interface Job {
  /** UUID of the job. */
  readonly id: string;
  /** Kind of work. `import`: reads files of points or labels; `tracking`: carries labels to other frames; `export`: writes files; `prediction`: applies a classifier; `fitting`: fits boxes */
  readonly kind: 'import' | 'tracking' | 'export' | 'prediction' | 'fitting';
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

/** An entry of the palette. */
export interface Label {
  /** 1 to 65534; never given to another label of the recording. */
  readonly id: number;
  /** Text that people see, unique in the recording. */
  readonly name: string;
  /** Name of the label's class; empty: none. */
  readonly category: string;
  /** ``#rrggbb``. */
  readonly color: string;
  /** Edits change neither the label nor its points. */
  readonly locked: boolean;
  /** The page shows its points; edits skip hidden points. */
  readonly visible: boolean;
  /** Number of its points in all frames, without deleted ones; only lists of labels have it. */
  readonly points: number | null;
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

/** Choices on how label files are read. */
export interface LabelImportOptions {
  /** Format of the label files; null: detected. */
  readonly format?: string | null;
  /** Names of classes as JSON, YAML, XML of point_labeler, or lines ``number name``. */
  readonly map?: string | null;
  /** Leave the ground inside boxes without the box's label. */
  readonly no_ground?: boolean;
  /** Match files to frames by their order instead of their names. */
  readonly by_order?: boolean;
  /** Accept files that label nothing. */
  readonly allow_empty?: boolean;
  /** Field of the points that holds the labels; null: detected. */
  readonly field?: string | null;
  /** ``keep`` boxes, label the ``points`` inside them, or ``both``. */
  readonly boxes?: string;
  /** UUID of the job: a repeated call does not begin another job. */
  readonly id?: string | null;
}

/** Label files that the server can already read. */
export interface LabelImportRequest {
  /** Format of the label files; null: detected. */
  readonly format?: string | null;
  /** Names of classes as JSON, YAML, XML of point_labeler, or lines ``number name``. */
  readonly map?: string | null;
  /** Leave the ground inside boxes without the box's label. */
  readonly no_ground?: boolean;
  /** Match files to frames by their order instead of their names. */
  readonly by_order?: boolean;
  /** Accept files that label nothing. */
  readonly allow_empty?: boolean;
  /** Field of the points that holds the labels; null: detected. */
  readonly field?: string | null;
  /** ``keep`` boxes, label the ``points`` inside them, or ``both``. */
  readonly boxes?: string;
  /** UUID of the job: a repeated call does not begin another job. */
  readonly id?: string | null;
  /** Path on the server, below one of its allowed folders. */
  readonly path: string;
}

/** Changes of a label; missing fields and null do not change it. */
export interface LabelPatch {
  /** New text that people see. */
  readonly name?: string | null;
  /** Name of its new class; empty: none. */
  readonly category?: string | null;
  /** New colour, ``#rrggbb``. */
  readonly color?: string | null;
  /** Refuse edits of the label and its points. */
  readonly locked?: boolean | null;
  /** Show its points on the page. */
  readonly visible?: boolean | null;
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
}

/** Result of masks that became labels. */
export interface MaskEdit {
  /** UUID of the edit. */
  readonly edit: string;
  /** Number of points with a new label, provenance or deletion. */
  readonly changed: number;
  /** Revision of the recording after the edit. */
  readonly revision: number;
  /** Number of points in the masks' values that have a label or class. */
  readonly seen: number;
  /** Number of points that stay as they are, because they are near a border of a mask or cameras disagree. */
  readonly doubt: number;
}

/** The caller, and the messages that the server speaks. */
export interface Me {
  /** Name that edits show. */
  readonly author: string;
  /** Role in the workspace. `viewer`: sees recordings and labels; `annotator`: changes labels; `reviewer`: accepts and rejects labels; `manager`: manages recordings, projects and accounts; `admin`: manages the server */
  readonly role: 'viewer' | 'annotator' | 'reviewer' | 'manager' | 'admin';
  /** Hash of the socket's messages, part of its subprotocol. */
  readonly schema: string;
  /** Version of the server. */
  readonly version: string;
}

/** Labels to merge into another label. */
export interface Merge {
  /** Ids of the labels that are removed. */
  readonly labels: readonly number[];
}

/** Classes to merge into another class. */
export interface MergedCategories {
  /** Numbers of the classes that are removed. */
  readonly categories: readonly number[];
}

/** Additional recordings to learn from. */
export interface MoreExamples {
  /** Ids of the recordings; empty: learn again from the known ones. */
  readonly recordings?: readonly string[];
}

/** Placement of a tracked label's points. */
export interface Moving {
  /** Id of the label. */
  readonly label: number;
  /** Transform to the shown frame by the label's track, source coordinates. */
  readonly T_shown_frame: readonly number[];
}

/** A new account with its first token. */
export interface NewAccount {
  /** Days until it expires; null: never. */
  readonly days?: number | null;
  /** Role that its token gives. `viewer`: sees recordings and labels; `annotator`: changes labels; `reviewer`: accepts and rejects labels; `manager`: manages recordings, projects and accounts; `admin`: manages the server */
  readonly role?: 'viewer' | 'annotator' | 'reviewer' | 'manager' | 'admin';
  /** Name of the account, which edits show. */
  readonly account: string;
}

/** A new box. */
export interface NewBox {
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
  /** UUID of the edit, which is applied once. */
  readonly edit: string | null;
}

/** A new classifier. */
export interface NewClassifier {
  /** Text that people see. */
  readonly name: string;
  /** Ids of the recordings whose painted points are its examples, now and later. */
  readonly recordings: readonly string[];
  /** Names of its classes; null: all classes in the palettes of its recordings. */
  readonly classes?: readonly string[] | null;
  /** Name of a plug-in or service of this server that replaces the trees; empty: trees. */
  readonly model?: string;
  /** Learn from imported labels as well. */
  readonly imported?: boolean;
  /** Ids of labelled recordings to begin with; the more is painted, the less they count. */
  readonly start_from?: readonly string[];
}

/** A report that was stored. */
export interface NewHeadsetReport {
  /** Id of the report. */
  readonly id: string;
}

/** Keyboard shortcuts of the caller, which replace the earlier ones. */
export interface NewKeys {
  /** Keys by the text of the command. */
  readonly keys: Readonly<Record<string, string>>;
}

/** A new label; the server chooses a missing ``id`` and ``color``. */
export interface NewLabel {
  /** Text that people see. */
  readonly name: string;
  /** Name of a class; empty: none. */
  readonly category?: string;
  /** ``#rrggbb``; null: a colour that differs from the palette's. */
  readonly color?: string | null;
  /** Number of the label; null: the lowest free one. */
  readonly id?: number | null;
  /** Refuse edits of the label and its points. */
  readonly locked?: boolean;
  /** Show its points on the page. */
  readonly visible?: boolean;
  /** Replace a name or colour that is in use by a free one, for example "pin 2". */
  readonly distinct?: boolean;
}

/** A new project. */
export interface NewProject {
  /** Role in the project by account; empty: every account has its role in the workspace. */
  readonly roles?: Readonly<Record<string, 'viewer' | 'annotator' | 'reviewer' | 'manager' | 'admin'>> | null;
  /** Numbers of the selected categories; null: all categories. */
  readonly categories?: readonly number[] | null;
  /** Ids of recordings, which move from their former projects. */
  readonly recordings?: readonly string[] | null;
  /** Text that people see. */
  readonly name: string;
  /** Name in URLs; null: derived from ``name``. */
  readonly id?: string | null;
}

/** A version to create of the current labels. */
export interface NewSnapshot {
  /** Text that people see. */
  readonly name: string;
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
  /** Id of the account. */
  readonly account: string;
  /** The secret. */
  readonly token: string;
}

/** A token to create. */
export interface NewTokenRequest {
  /** Role that it gives; null: the account's role.  `viewer`: sees recordings and labels; `annotator`: changes labels; `reviewer`: accepts and rejects labels; `manager`: manages recordings, projects and accounts; `admin`: manages the server */
  readonly role?: 'viewer' | 'annotator' | 'reviewer' | 'manager' | 'admin' | null;
  /** Days until it expires; null: never. */
  readonly days?: number | null;
}

/** A webhook to add. */
export interface NewWebhook {
  /** Address that receives the events. */
  readonly url: string;
  /** Events to send; null: all. */
  readonly topics?: readonly ('task' | 'labels' | 'job')[] | null;
}

/** A request for the next task. */
export interface NextTask {
  /** Kind of work. `label`: label frames; `review`: review the labels of other people */
  readonly work?: 'label' | 'review';
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

/** Labels to add, or a template that contains them. */
export interface PaletteAddition {
  /** Name of a well-known dataset, from ``GET /templates``. */
  readonly template?: string | null;
  /** Labels of a file; those whose name and category the palette has are skipped. */
  readonly labels?: readonly PaletteLabel[];
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

/** Order of the palette. */
export interface PaletteOrder {
  /** Ids of labels, first to last; missing labels follow. */
  readonly labels: readonly number[];
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

/** Changes of a pose; missing fields and null do not change it. */
export interface PosePatch {
  /** New centre, source coordinates, metres; counts as drawn. */
  readonly centre?: readonly [number, number, number] | null;
  /** New rotation x, y, z, w; counts as drawn. */
  readonly quaternion?: readonly [number, number, number, number] | null;
  /** New origin of the pose.  `fitted`: fitted to the label's points; `drawn`: drawn or moved by a person; `imported`: read from a file */
  readonly provenance?: 'fitted' | 'drawn' | 'imported' | null;
  /** New confidence in the pose, 0 to 1. */
  readonly confidence?: number | null;
  /** Attributes in this frame by name; null removes one, others do not change. */
  readonly attributes?: Readonly<Record<string, string | number | boolean | null>>;
}

/** Points to predict. */
export interface PredictionRequest {
  /** Id of the classifier. */
  readonly classifier: string;
  /** Ids of the only labels to predict; null: all of its classes. */
  readonly labels?: readonly number[] | null;
  /** Predict only near this place, source coordinates, metres; null: the whole frame. */
  readonly place?: readonly [number, number, number] | null;
}

/** Preview of an import of files: the frames, fields and labels that it would store. */
export interface Preview {
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
  /** Frame of each file: ``file`` and ``frame``, the first hundred. */
  readonly files: readonly (Readonly<Record<string, unknown>>)[];
  /** ``points`` and points ``left_out`` of the first frames. */
  readonly points: readonly (Readonly<Record<string, number>>)[];
  /** ``name`` and ``meaning`` of each column. */
  readonly columns: readonly (Readonly<Record<string, string>>)[];
  /** ``name``, ``type`` and number of ``messages`` of each topic of a bag. */
  readonly topics: readonly (Readonly<Record<string, unknown>>)[];
  /** ``name`` of each camera with pictures. */
  readonly cameras: readonly (Readonly<Record<string, unknown>>)[];
  /** ``source`` of the poses, and whether frames ``agree`` by them; null: none. */
  readonly poses: Readonly<Record<string, unknown>> | null;
  /** ``name`` of the unit, its ``scale`` in metres, and the ``extent`` of the points. */
  readonly units: Readonly<Record<string, unknown>>;
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

/** Values to set; missing fields do not change. */
export interface ProjectPatch {
  /** Text that people see. */
  readonly name?: string | null;
  /** Role in the project by account; empty: every account has its role in the workspace. */
  readonly roles?: Readonly<Record<string, 'viewer' | 'annotator' | 'reviewer' | 'manager' | 'admin'>> | null;
  /** Numbers of the selected categories; null: all categories. */
  readonly categories?: readonly number[] | null;
  /** Ids of recordings, which move from their former projects. */
  readonly recordings?: readonly string[] | null;
}

/** Readiness of the server for work. */
export interface Ready {
  /** State of the whole. `ready`: all parts work; `not ready`: a part has a fault */
  readonly status: 'ready' | 'not ready';
  /** ``ok`` or the fault of each part, by its name. */
  readonly parts: Readonly<Record<string, string>>;
}

/** Changes of a recording; missing fields and null do not change it. */
export interface RecordingPatch {
  /** New text that people see. */
  readonly name?: string | null;
  /** Frames per second of playback, at most 1000. */
  readonly fps?: number | null;
  /** Transform from local coordinates to the floor of the page, y up, row by row. */
  readonly room?: readonly number[] | null;
}

/** Points to merge. */
export interface Region {
  /** Ids of labels, by the id of the copy: only their points are merged. */
  readonly labels: Readonly<Record<string, readonly number[]>>;
  /** Frame of the points; null: all submitted frames. */
  readonly frame?: number | null;
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
  /** New state; accepting and rejecting need the role reviewer.  `open`: not reviewed; `review`: waits for a reviewer; `accepted`: accepted by a reviewer; `rejected`: rejected by a reviewer */
  readonly state?: 'open' | 'review' | 'accepted' | 'rejected' | null;
  /** New note; empty: removes the note. */
  readonly note?: string | null;
  /** Position that the note is pinned to, source coordinates, metres. */
  readonly place?: readonly [number, number, number] | null;
  /** Account that the frames are assigned to; empty: not assigned. */
  readonly assignee?: string | null;
  /** Id of a label to review instead of the frames themselves. */
  readonly label?: number | null;
  /** First frame; null: the label as a whole. */
  readonly first?: number | null;
  /** Last frame, included. */
  readonly last?: number | null;
}

/** Frames, or a label in them, that a review is about. */
export interface ReviewedFrames {
  /** First frame; null: the label as a whole. */
  readonly first: number | null;
  /** Last frame, included. */
  readonly last: number | null;
  /** Id of the label; null: the frames themselves. */
  readonly label: number | null;
}

/** Result of a tracking run. */
export interface Run {
  /** UUID of the edit. */
  readonly edit: string;
  /** Number of points with a new label, provenance or deletion. */
  readonly changed: number;
  /** Revision of the recording after the edit. */
  readonly revision: number;
  /** Number of frames with new labels. */
  readonly frames: number;
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

/** Sign in with a token. */
export interface SignIn {
  /** Token of an account, as the server or a manager printed it. */
  readonly token: string;
}

/** The signed-in person. */
export interface SignedIn {
  /** Name that edits show. */
  readonly author: string;
  /** Role in the workspace. `viewer`: sees recordings and labels; `annotator`: changes labels; `reviewer`: accepts and rejects labels; `manager`: manages recordings, projects and accounts; `admin`: manages the server */
  readonly role: 'viewer' | 'annotator' | 'reviewer' | 'manager' | 'admin';
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

/** A labelled recording from which a classifier can start. */
export interface Start {
  /** Id of the recording. */
  readonly recording: string;
  /** Classes that it has labels of. */
  readonly classes: readonly string[];
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

/** Labels in a range of frames. */
export interface Stretch {
  /** Ids of the labels. */
  readonly labels: readonly number[];
  /** UUID of the edit, which is applied once. */
  readonly id?: string | null;
  /** One end of the range. */
  readonly start: number;
  /** Other end of the range, included. */
  readonly stop: number;
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
  /** New state.  `open`: not assigned; `taken`: being labelled; `done`: labelled, waits for a review; `review`: being reviewed; `accepted`: accepted by a reviewer; `returned`: to be labelled again */
  readonly state?: 'open' | 'taken' | 'done' | 'review' | 'accepted' | 'returned' | null;
  /** Account that the task is assigned to; empty: any. */
  readonly assignee?: string | null;
  /** New note; empty: removes the note. */
  readonly note?: string | null;
  /** Frame of ``place``. */
  readonly frame?: number | null;
  /** Position that the note is pinned to, source coordinates, metres. */
  readonly place?: readonly [number, number, number] | null;
}

/** The classes of a workspace and the attributes of boxes; can be put into another workspace. */
export interface Taxonomy {
  /** All classes, by number. */
  readonly categories: readonly Category[];
  /** Attributes of boxes, in the order of the page. */
  readonly attributes: readonly BoxAttribute[];
}

/** Classes to add, and new names, colours and sizes of existing classes. */
export interface TaxonomyChange {
  /** Classes by their numbers; other classes do not change. */
  readonly categories?: readonly Category[];
  /** All attributes of boxes; null keeps the existing ones. */
  readonly attributes?: readonly BoxAttribute[] | null;
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

/** A label's track in one frame. */
export interface Track {
  /** Id of the label. */
  readonly label: number;
  /** Number of the frame. */
  readonly frame: number;
  /** Transform (4, 4) from the start frame to this frame, source coordinates. */
  readonly pose: readonly number[];
  /** Root mean square distance of the inliers, metres; null: not registered. */
  readonly rmse: number | null;
  /** Share of the model's points with a point near them, 0 to 1. */
  readonly inliers: number;
  /** Confidence in the pose, 0 to 1; below 0.5 a person should look. */
  readonly confidence: number;
  /** Number of points that got the label. */
  readonly points: number;
  /** Outcome in this frame. `tracked`: found in the frame; `occluded`: hidden by something nearer; `lost`: not found; `painted`: labelled by a person */
  readonly state: 'tracked' | 'occluded' | 'lost' | 'painted';
}

/** A tracking run, which is one edit. */
export interface TrackingRequest {
  /** First frame, which has the labels. */
  readonly start: number;
  /** Last frame; below ``start``: the run goes backward. */
  readonly stop: number;
  /** Ids of the labels; null: all labels with points in the first frame. */
  readonly labels?: readonly number[] | null;
  /** Method: ``auto``, ``icp``, ``color-icp`` or the name of a plug-in. */
  readonly method?: string;
  /** Labelled points that the run may replace. `never`: unlabeled points only; `tracked`: also tracked and predicted points; `all`: also painted points */
  readonly overwrite?: 'never' | 'tracked' | 'all';
  /** Search for a lost label in later frames instead of ending it. */
  readonly continue_lost?: boolean;
  /** End a label at the next frame in which it is painted. */
  readonly until_painted?: boolean;
  /** End the run at a frame with a doubtful label. */
  readonly stop_unsure?: boolean;
  /** UUID of the job and of its edit: a repeated call does not begin another run. */
  readonly id?: string | null;
}

/** An undo or redo of the caller's edits. */
export interface Undo {
  /** UUID of the undo, which is applied once; null: the server chooses one. */
  readonly id?: string | null;
  /** UUID of the edit to undo or redo; null: the last one. */
  readonly edit?: string | null;
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

export interface _Numbered {
  /** Number of the box, never given to another box of the recording. */
  readonly id: number;
}
