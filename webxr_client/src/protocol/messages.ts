// Generated from streaming/messages/ of server/pointbrush by
// `python -m pointbrush.streaming.typescript --write`.
// Do not edit: a stale file fails the tests.

export const SCHEMA_HASH = '547ebd1a4072';
export const SUBPROTOCOL = `pointbrush.${SCHEMA_HASH}`;

/**
 * Request the points that a stroke of shape object, grow, cluster or plane would take.
 *
 * The server answers the newest request and drops an older one that still waits.  Without
 * ``samples``, the answer only reports whether the frame is prepared for the object tool, and the
 * server prepares it.
 */
export interface Ask {
  type: 'ask';
  id: string;
  frame: number;
  brush: Brush;
  /** Rays at the object or at the region. */
  samples: Sample[];
  /** Rays at points that do not belong to the object. */
  negatives?: Sample[];
  /** The candidate taken so far; the new candidates stay close to it if the clicks allow that. */
  previous?: string;
}

/** Action of a stroke on its samples. */
export interface Brush {
  /** sphere, ray, grow, cluster, plane, object: metres */
  radius?: number;
  /** ray: take all points along the ray, not only the first surface */
  through?: boolean;
  /** lasso: vertices in normalised device coordinates, x right and y up, -1..1 */
  polygon?: ([number, number])[] | null;
  /** lasso: `clip_from_source`, the camera's projection times view, row-major */
  matrix?: number[] | null;
  /** box: metres */
  center?: [number, number, number] | null;
  /** box: full edge lengths, metres */
  size?: [number, number, number] | null;
  /** box: orientation x, y, z, w */
  quaternion?: [number, number, number, number] | null;
  /** object: rays at points that do not belong to it */
  negatives?: Sample[];
  /** object: id of a candidate of the frame as it is now; the server refuses other ids (409) */
  candidate?: string;
  /** object: without `candidate`: the level to take, from 0 (the smallest); null: the best */
  level?: number | null;
  /** object: the candidate taken so far, as in the request */
  previous?: string;
  /** object: also points of other labels */
  take_labelled?: boolean;
  /** object: this author's last edit, which the stroke replaces: one undo reverts a refined object */
  replaces?: string | null;
  /** Id of the label to paint; 0 for the other tools. */
  label?: number;
  /**
   * `paint`: give the label; `erase`: remove labels; `delete`: delete points as noise;
   * `restore`: bring deleted points back.
   */
  tool?: 'paint' | 'erase' | 'delete' | 'restore';
  /** `sphere`: The volume that a ball sweeps along the samples' origins. `ray`: A ball round the first surface that each ray meets, or all along the ray. `lasso`: Points that a camera sees inside an outline. `box`: The inside of a box. `grow`: The connected region of similar colour and normal round each place met. `cluster`: Points above the ground round each place met, without gaps wider than the radius. `plane`: The flat surface round each place met: ground, a wall. `object`: A candidate of the object tool; the samples are rays at the object. */
  shape?: 'sphere' | 'ray' | 'lasso' | 'box' | 'grow' | 'cluster' | 'plane' | 'object';
  /** Paint only points without a label. */
  only_unlabeled?: boolean;
  /** labels that only this viewer hides, beside the hidden labels of the palette; 0: points without a label. Strokes do not change their points, and rays pass through them. */
  hidden?: number[];
  /** numbers of the sensors that this viewer hides. Strokes do not change their points, and rays pass through them. */
  hidden_sensors?: number[];
  /** further frames that the stroke paints, in the same edit. The poses of the recording place their points over the stroke's frame; the track places a tracked label's points. */
  frames?: number[];
  /** the visible box: no shape changes points outside it, and rays pass through them. */
  clip?: ClipBox | null;
}

/** Position of this person in room coordinates (y up, metres); missing parts are null. */
export interface ClientPresence {
  type: 'presence';
  frame?: number;
  head?: [number, number, number, number, number, number, number] | null;
  hands?: ([number, number, number, number, number, number, number] | null)[];
  brush?: [number, number, number] | null;
  radius?: number;
  label?: number;
}

/** A box in the coordinates of the frame that a stroke is drawn in. */
export interface ClipBox {
  /** metres */
  center: [number, number, number];
  /** full edge lengths, metres */
  size: [number, number, number];
  /** orientation x, y, z, w */
  quaternion?: [number, number, number, number];
}

/**
 * The client has applied ``frames`` frame messages; the server may send as many more.
 *
 * With 0 frames the message only reports the speed of the page.  ``frame_ms`` is the page's
 * measured time per rendered frame, ``target_ms`` the time that its display allows; the server
 * sends fewer points to a slow page.  ``points`` limits the points per frame.
 */
export interface Credit {
  type: 'credit';
  frames?: number;
  nbytes?: number;
  decode_ms?: number;
  frame_ms?: number;
  target_ms?: number;
  points?: number | null;
}

/** Frames that the client has dropped from its cache; the server sends them again when shown. */
export interface Forget {
  type: 'forget';
  frames: number[];
}

/** First message: the name and colour of the person; the server answers ``welcome``. */
export interface Hello {
  type: 'hello';
  name?: string;
  color?: string | null;
  /** The server may send frames of depth cameras as ``depth`` messages instead of ``frame``. */
  depth?: boolean;
}

/**
 * Open a sequence; a client that resumes sends the last ``revision`` that it has.
 *
 * ``held`` lists the frames that the client still has, each with the number of its chunks from the
 * first on; the server does not send these chunks again.  Without ``held``, it sends the edits of
 * all frames and all points.  ``identity`` is the import that ``revision`` and ``held`` belong to;
 * if the sequence has another identity, it is opened anew.
 */
export interface Open {
  type: 'open';
  sequence: string;
  frame?: number;
  identity?: string | null;
  revision?: number | null;
  held?: ([number, number])[] | null;
}

/** Stop the clock, at ``frame`` if given; the server refines this frame to all its points. */
export interface Pause {
  type: 'pause';
  frame?: number | null;
}

/** Play frames by a clock that starts at ``frame`` when this message arrives. */
export interface Play {
  type: 'play';
  frame: number;
  speed?: number;
  loop?: boolean;
}

/** Restore the edit that this author's last undo took back; answered like ``undo``. */
export interface Redo {
  type: 'redo';
  id: string;
}

/** One sample of the controller or mouse: a ray, and the time since the stroke began. */
export interface Sample {
  /** Position of the device or the eye, source coordinates, metres. */
  origin: [number, number, number];
  /** Direction of the ray, of any length. */
  direction?: [number, number, number];
  /** Milliseconds since the stroke began. */
  t?: number;
}

/**
 * Show one frame: its first levels at once, then refinement up to all points.
 *
 * ``around``: frames that are laid over it; they are sent likewise, after it and in this order.
 */
export interface Seek {
  type: 'seek';
  frame: number;
  around?: number[];
}

/** A stroke starts; the server applies an ``id`` once, also when it is sent twice. */
export interface StrokeBegin {
  type: 'stroke_begin';
  id: string;
  frame: number;
  brush: Brush;
}

/** Cancel a stroke before its end: it changes nothing, and there is no answer. */
export interface StrokeCancel {
  type: 'stroke_cancel';
  id: string;
}

/**
 * The stroke ends; the server answers a final ``stroke_result`` when the edit is durable.
 *
 * ``touched``: the points that the client found in the shape, in each frame; the server takes
 * these instead of its own selection, and applies the rules of tools, locks and hidden labels to
 * them.  A client may send them if it has all points of the stroke's frames; positions in chunks
 * are rounded, so that its selection differs from the server's at the border of the shape.
 */
export interface StrokeEnd {
  type: 'stroke_end';
  id: string;
  touched?: TouchedPoints[] | null;
}

/** More samples of a stroke; the server answers ``stroke_result``, which is not final. */
export interface StrokeSamples {
  type: 'stroke_samples';
  id: string;
  samples: Sample[];
}

/** Points of a frame: ``runs`` holds first number and length of ascending runs, uint32 each. */
export interface TouchedPoints {
  frame: number;
  runs: Uint8Array;
}

/** Start a tracking run; the server sends its ``job`` messages. */
export interface Track {
  method?: string;
  /** `never`: unlabeled points only; `tracked`: also tracked and predicted points; `all`: also painted points */
  overwrite?: 'never' | 'tracked' | 'all';
  continue_lost?: boolean;
  until_painted?: boolean;
  stop_unsure?: boolean;
  type: 'track';
  id: string;
  labels?: number[] | null;
  start: number;
  stop: number;
}

/** Take back this author's last edit; the server answers a final ``stroke_result``. */
export interface Undo {
  type: 'undo';
  id: string;
}

/** Chunks of a large frame in the order of urgency; the list replaces the previous one. */
export interface Want {
  type: 'want';
  frame: number;
  chunks: number[];
}

/**
 * Label values of a frame's points, whole (``base`` null) or as a delta from ``base``.
 *
 * A value is a label id, 0 for unlabeled, or 65535 for a deleted point.
 * Whole: runs over [first, first + count): ``lengths`` uint32 and ``values`` uint16, as many.
 * Delta: ``lengths`` holds sorted uint32 point numbers, ``values`` one uint16 for each, or a
 * single one for all.  A client that applies all messages in order of arrival is always right.
 * ``base`` is not older than the last change of the frame and not newer than the viewer's labels.
 * A client with labels of the frame older than ``base`` has missed a message and sends
 * ``open`` with the last revision that it knows to be complete.  The server answers ``sequence``,
 * which holds for all frames of the client; the deltas up to its revision follow.
 */
export interface Annotation {
  type: 'annotation';
  sequence: string;
  frame: number;
  revision: number;
  base: number | null;
  edit: string | null;
  author: string | null;
  /** True: a result of a tracking run that is not committed yet. */
  provisional: boolean;
  first: number;
  count: number;
  lengths: Uint8Array;
  values: Uint8Array;
}

/** An oriented box of a label. */
export interface Box {
  /** Number of the box, never given to another box of the recording. */
  id: number;
  /** Id of the label. */
  label: number;
  /** Length, width and height along the box's x, y and z, metres. */
  size: [number, number, number];
  /** Pose in each frame, by the frame's number. */
  poses: Record<string, BoxPose>;
  /** Attributes of the box in all frames, by name. */
  attributes: Record<string, string | number | boolean>;
  /** Origin of the box. `fitted`: fitted to the label's points; `drawn`: drawn or moved by a person; `imported`: read from a file */
  provenance: 'fitted' | 'drawn' | 'imported';
  /** False: the front of the object may also be at the opposite end of the box. */
  heading_known: boolean;
}

/** Pose of a box in one frame. */
export interface BoxPose {
  /** Centre of the box, source coordinates, metres. */
  centre: [number, number, number];
  /** x, y, z, w: from the box's axes (x forward, y left, z up) to the axes of the frame. */
  quaternion: [number, number, number, number];
  /** Origin of the pose. `fitted`: fitted to the label's points; `drawn`: drawn or moved by a person; `imported`: read from a file */
  provenance: 'fitted' | 'drawn' | 'imported';
  /** Confidence in the pose, 0 to 1. */
  confidence: number;
  /** Attributes in this frame, by name; they take precedence over the box's. */
  attributes: Record<string, string | number | boolean>;
}

/**
 * Changed boxes in their new state, and the ids of removed boxes.
 *
 * Sent with all boxes after ``open`` (``whole``), and then with every edit that changes boxes.
 */
export interface Boxes {
  type: 'boxes';
  sequence: string;
  revision: number;
  whole: boolean;
  boxes: Box[];
  removed: number[];
}

/**
 * Points that a click would take: ``runs`` holds first number and length, uint32 each.
 *
 * ``id`` is opaque and becomes void when the frame or the clicks change; it is empty for the
 * regions of other shapes.  ``score``: the expected overlap with the object, 0..1.
 */
export interface Candidate {
  id: string;
  level: number;
  score: number;
  points: number;
  runs: Uint8Array;
}

/**
 * The answer to ``ask``: at most six candidates from part to group.
 *
 * ``first``: the candidate to show first.  ``ready``: the whole frame is prepared; otherwise the
 * candidates come from the points near the clicks.
 */
export interface Candidates {
  type: 'candidates';
  id: string;
  frame: number;
  first: number;
  ready: boolean;
  candidates: Candidate[];
}

/**
 * A run of points, encoded with the meshoptimizer vertex codec, 12 bytes per point.
 *
 * Decoded layout: x, y, z uint16; r, g, b, intensity uint8; flags uint8; a zero byte.
 * If bit 0 of the first vertex's flags is set, g was subtracted from all r and b (modulo 256).
 * Bits 1 and 2 are the number n of low bits that r, g and b have lost:
 * value = v << n | v >> (8 - 2n).  If n = 3, the bytes of r and g are a little-endian word with r
 * (lowest), g and b in 5, 6 and 5 bits.
 * Position = ``origin + q * scale``, in the sequence's local coordinates (source minus shift), or
 * in those of its sensor if there are several.
 */
export interface Chunk {
  index: number;
  level: number;
  first: number;
  count: number;
  /** Byte offset in the message's ``data`` (in a frame message) or in the frame's wire file. */
  offset: number;
  nbytes: number;
  origin: [number, number, number];
  scale: [number, number, number];
  /** Number of the sensor of its points; left out if the recording has one sensor. */
  sensor?: number | null;
  /** Bounds of its points, local coordinates. */
  lo: [number, number, number];
  hi: [number, number, number];
}

/**
 * Progress of a step of compiling loops, which a server does once on its machine.
 *
 * Sent after ``welcome`` for each step that is not done, and at each hundredth; with ``share`` 1
 * a step is done.  Questions about objects wait for ``objects``, tracking runs for ``things``.
 */
export interface Compiling {
  type: 'compiling';
  step: 'objects' | 'things' | 'people' | 'imports' | 'example' | 'paper';
  share: number;
  /** Time that probably remains; null: the step has not begun. */
  seconds: number | null;
}

/**
 * Chunks of a frame as parts of a depth image, instead of ``frame``; same chunk numbers.
 *
 * Sent to clients that set ``depth`` in ``hello``.  A chunk needs the depths of all chunks of its
 * sensor before it.
 */
export interface Depth {
  type: 'depth';
  sequence: string;
  frame: number;
  total: number;
  /** The frame is complete at the client once this is applied. */
  final: boolean;
  chunks: DepthChunk[];
  data: Uint8Array;
}

/**
 * A run of points as a band of a depth image: docs/depth-format.md.
 *
 * In a recording of several sensors each depth camera has a depth image, and the chunks of other
 * sensors are points.
 */
export interface DepthChunk {
  index: number;
  level: number;
  first: number;
  count: number;
  /** Byte offset in the message's ``data``. */
  offset: number;
  nbytes: number;
  /** As of `frame`, for a chunk of points; left out for a band of a depth image. */
  origin?: [number, number, number] | null;
  /** As of `frame`, for a chunk of points; left out for a band of a depth image. */
  scale?: [number, number, number] | null;
  /** Number of the sensor of its points; left out if the recording has one sensor. */
  sensor?: number | null;
  /** Bounds of its points, local coordinates. */
  lo: [number, number, number];
  hi: [number, number, number];
}

/** RFC 9457 fields; ``about`` is the id of the refused stroke, undo, track or ask, if any. */
export interface Error {
  type: 'error';
  title: string;
  detail: string;
  status: number;
  about: string | null;
  /** The sequence that was closed for this viewer: it was deleted or cannot be read. */
  closed: string | null;
}

/**
 * Chunks of a frame in stored order: a prefix of the frame, or its continuation.
 *
 * For a large frame: the requested chunks.  The whole ``annotation`` of these points comes just
 * before, so that points never show without their labels.
 */
export interface Frame {
  type: 'frame';
  sequence: string;
  frame: number;
  total: number;
  /** The frame is complete at the client once this is applied. */
  final: boolean;
  chunks: Chunk[];
  data: Uint8Array;
}

/** State and progress of a job. */
export interface Job {
  type: 'job';
  id: string;
  kind: 'import' | 'tracking' | 'export' | 'prediction' | 'fitting' | 'alignment';
  sequence: string | null;
  state: 'queued' | 'running' | 'done' | 'failed' | 'cancelled';
  progress: number;
  message: string;
  frame: number | null;
  error: string | null;
  /** The edit that the job makes: the id of the ``track`` message that started it. */
  edit: string | null;
  /** The account that started the job; this account and managers may stop it. */
  owner: string;
}

/** An entry of the palette. */
export interface Label {
  id: number;
  name: string;
  category: string;
  color: string;
  locked: boolean;
  visible: boolean;
}

/** The whole palette, and the number of points of each label in all frames. */
export interface Labels {
  type: 'labels';
  sequence: string;
  revision: number;
  labels: Label[];
  counts: Record<string, number>;
  /** Summary of the edit that an undo of this author would take back, or null. */
  undo: string | null;
  redo: string | null;
}

/**
 * Pixels of a depth camera, equal for all frames of a recording.
 *
 * With a depth of d units, the point of pixel (column, row) is d * ``unit`` metres from ``eye``
 * along ``sign`` times axis ``axis``, and (``tangent`` + ``pitch`` * pixel) times this distance
 * along the other two axes: the first with the column, the second with the row.
 */
export interface Lattice {
  width: number;
  height: number;
  axis: number;
  sign: -1 | 1;
  tangent: [number, number];
  pitch: [number, number];
  /** Local coordinates (source minus shift). */
  eye: [number, number, number];
  unit: number;
}

/** A frame is prepared for the object tool: further answers use all its points. */
export interface Prepared {
  type: 'prepared';
  sequence: string;
  frame: number;
}

/**
 * One of several sensors of a recording.
 *
 * Its chunks and its lattice are in its own coordinates.  A point p of it is at
 * ``T_frame_sensor * correction * p`` in local coordinates.
 */
export interface SensorInfo {
  name: string;
  /** `depth`: a depth camera; `spinning`: a lidar that turns; `solid-state`: a lidar without a turning head; `radar`: a radar; `unknown`: the files do not tell */
  type: 'depth' | 'spinning' | 'solid-state' | 'radar' | 'unknown';
  /** Pixels of its chunks in ``depth`` messages; null: they are points. */
  lattice: Lattice | null;
  /** Mount in the frames: one for all, or one for each frame. */
  T_frame_sensor: number[][];
  /** Correction of the mounts; the identity: none. */
  correction: number[];
}

/** The answer to ``open``; sent again when the manifest changes. */
export interface SequenceInfo {
  type: 'sequence';
  id: string;
  /**
   * Id of this import and of the corrections of its sensors' mounts: data of another one is void,
   * even under the same ``id``.
   */
  identity: string;
  name: string;
  frames: number;
  fps: number;
  points: number[];
  fields: string[];
  shift: [number, number, number];
  lo: [number, number, number];
  /** Bounds over all frames, in local coordinates (source minus shift). */
  hi: [number, number, number];
  /** ``T_room_local``: places the recording on the floor, y up, metres. */
  room: number[];
  /** True: some or all frames have camera pictures. */
  cameras: boolean;
  /** True: chunks form an octree; request them with ``want``, and their table over HTTP. */
  large: boolean;
  /** Greatest difference of a streamed and the stored coordinate, metres per axis. */
  position_error: number;
  /** Greatest root mean square difference of a ``depth`` frame's colours from the stored ones. */
  color_error: number;
  /** The pixels of ``depth`` messages; null: there are none, or each sensor has its own. */
  lattice: Lattice | null;
  /** Sensors by number, if the recording has several; else none. */
  sensors: SensorInfo[];
  revision: number;
  frame: number;
}

/** Position of another person; ``left``: the person has left. */
export interface ServerPresence {
  type: 'presence';
  viewer: string;
  name: string;
  color: string;
  left: boolean;
  frame: number;
  head: [number, number, number, number, number, number, number] | null;
  hands: ([number, number, number, number, number, number, number] | null)[];
  brush: [number, number, number] | null;
  radius: number;
  label: number;
}

/**
 * ``touched``: number of points touched so far; ``final``: the edit is durable.
 *
 * ``changed``: number of touched points that the stroke changes; it drives the haptic pulse.
 */
export interface StrokeResult {
  type: 'stroke_result';
  id: string;
  frame: number;
  touched: number;
  changed: number;
  edit: string | null;
  revision: number;
  final: boolean;
}

/**
 * Changed cells (all cells after ``open``); remove a cell without points and state.
 *
 * A cell is a label in a frame.  Each array has one item for each cell.
 */
export interface Timeline {
  type: 'timeline';
  sequence: string;
  revision: number;
  whole: boolean;
  /** uint32. */
  frames: Uint8Array;
  /** uint16. */
  labels: Uint8Array;
  /** uint32. */
  points: Uint8Array;
  /** uint32: the number of points that a person painted. */
  painted: Uint8Array;
  /** float32, 0..1; NaN where the label was not tracked. */
  confidence: Uint8Array;
  /** uint8: 0 none, 1 painted, 2 tracked, 3 occluded, 4 lost. */
  states: Uint8Array;
}

/** The answer to ``hello``. */
export interface Welcome {
  type: 'welcome';
  viewer: string;
  author: string;
  /** `viewer`: sees recordings and labels; `annotator`: changes labels; `reviewer`: accepts and rejects labels; `manager`: manages recordings, projects and accounts; `admin`: manages the server */
  role: 'viewer' | 'annotator' | 'reviewer' | 'manager' | 'admin';
  version: string;
  /** Frame messages that the server may send before the client returns a credit. */
  credits: number;
  /** The account to which edits and jobs belong; ``author`` is its displayed name. */
  account: string;
}

export type ClientMessage =
  | Hello
  | Open
  | Play
  | Pause
  | Seek
  | Credit
  | Forget
  | Want
  | StrokeBegin
  | StrokeSamples
  | StrokeEnd
  | StrokeCancel
  | Ask
  | Undo
  | Redo
  | Track
  | ClientPresence;

export type ServerMessage =
  | Welcome
  | SequenceInfo
  | Frame
  | Depth
  | Annotation
  | StrokeResult
  | Candidates
  | Prepared
  | Compiling
  | Labels
  | Timeline
  | Boxes
  | Job
  | ServerPresence
  | Error;
