// Generated from streaming/messages/ and headset_report/ of server/pointbrush by
// `python -m pointbrush.streaming.typescript --write`.
// Do not edit: a stale file fails the tests.

export const SCHEMA_HASH = 'bd0676461d6d';
export const SUBPROTOCOL = `pointbrush.${SCHEMA_HASH}`;

/**
 * Request of what a stroke of shape ``object``, ``grow``, ``cluster`` or ``plane`` would take.
 *
 * The newest request counts: one that still waits when another comes is not answered.  Without
 * ``samples``: only whether the frame is prepared for objects, which it is from then on.
 */
export interface Ask {
  type: 'ask';
  id: string;
  frame: number;
  brush: Brush;
  samples: Sample[];
  negatives?: Sample[];
  previous?: string;
}

/** Action of a stroke on its samples. */
export interface Brush {
  /** sphere, ray, grow, cluster, plane, object: metres */
  radius?: number;
  /** ray: all points along the ray, not the first met */
  through?: boolean;
  /** lasso: vertices in normalised device coordinates, x right and y up, -1..1 */
  polygon?: [number, number][] | null;
  /** lasso: `clip_from_source`, the camera's projection times view, row-major */
  matrix?: number[] | null;
  /** box: metres */
  center?: [number, number, number] | null;
  /** box: full edge lengths, metres */
  size?: [number, number, number] | null;
  /** box: orientation x, y, z, w */
  quaternion?: [number, number, number, number] | null;
  /** object: rays at what is no part of it */
  negatives?: Sample[];
  /** object: the id of a candidate of the newest answer; another one is refused (409) */
  candidate?: string;
  /** object: without `candidate`: the level to take, from 0, the smallest; null: the best */
  level?: number | null;
  /** object: the candidate taken so far, as it was asked with */
  previous?: string;
  /** object: also points of other labels */
  take_labelled?: boolean;
  /** object: this author's last edit, taken back first, so that a refined object is one undo */
  replaces?: string | null;
  label?: number;
  tool?: 'paint' | 'erase' | 'delete' | 'restore';
  /** `sphere`: The volume that a ball sweeps along the samples' origins. `ray`: A ball round the first surface that each ray meets, or all along the ray. `lasso`: What a camera sees inside an outline. `box`: The inside of a box. `grow`: The connected region of like colour and normal round each place met. `cluster`: All that stands within the radius of each other round each place met, without the ground. `plane`: The flat surface round each place met: ground, a wall. `object`: A candidate of the object tool; the samples are rays at the object. */
  shape?: 'sphere' | 'ray' | 'lasso' | 'box' | 'grow' | 'cluster' | 'plane' | 'object';
  only_unlabeled?: boolean;
  /** labels that only this viewer hides, beside those that the palette hides; 0: points without a label. Their points are left alone, and rays pass through them. */
  hidden?: number[];
  /** painted beside the frame that the stroke is drawn in, as one edit: their points lie over it by the recording's poses, those of a tracked label by its track. */
  frames?: number[];
  /** box that is shown: points outside it are left alone, by every shape, and rays pass through them. */
  clip?: ClipBox | null;
}

/** Place of this person, in room coordinates (y up, metres); absent parts are null. */
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
 * The client applied ``frames`` frame messages and may be sent as many more.
 *
 * With 0 of them it only says how the page keeps up.  ``frame_ms`` is the page's measured time
 * per rendered frame, ``target_ms`` what its display wants; a page that falls behind is sent
 * fewer points.  ``points`` caps points per frame.
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

/** Frames that the client dropped from its cache and must be sent again when shown. */
export interface Forget {
  type: 'forget';
  frames: number[];
}

/** The first message: who this is; answered with ``welcome``. */
export interface Hello {
  type: 'hello';
  name?: string;
  color?: string | null;
  depth?: boolean;
}

/**
 * Open a sequence; ``revision`` is the last one the client has, when it resumes.
 *
 * ``held`` lists the frames that it still has, each with the number of chunks from the first on:
 * these are not sent again.  Without it, edits in all frames are told and points come anew.
 * ``identity`` is the import's that both are of: another one of this name is opened from new.
 */
export interface Open {
  type: 'open';
  sequence: string;
  frame?: number;
  identity?: string | null;
  revision?: number | null;
  held?: [number, number][] | null;
}

/** Stop the clock, at ``frame`` if given; that frame is refined to all its points. */
export interface Pause {
  type: 'pause';
  frame?: number | null;
}

/** Send frames in time with a clock that starts at ``frame`` when this arrives. */
export interface Play {
  type: 'play';
  frame: number;
  speed?: number;
  loop?: boolean;
}

/** Bring back what this author's last undo took; answered like ``undo``. */
export interface Redo {
  type: 'redo';
  id: string;
}

/** One sample of the controller or mouse: a ray, and the time since the stroke began. */
export interface Sample {
  origin: [number, number, number];
  direction?: [number, number, number];
  t?: number;
}

/**
 * Show one frame: its first levels at once, then refinement up to all points.
 *
 * ``around``: frames that are laid over it, sent as it is, after it and in this order.
 */
export interface Seek {
  type: 'seek';
  frame: number;
  around?: number[];
}

/** A stroke starts; the same ``id`` sent again after a lost connection applies once. */
export interface StrokeBegin {
  type: 'stroke_begin';
  id: string;
  frame: number;
  brush: Brush;
}

/** The stroke is given up before its end: nothing of it stays; there is no answer. */
export interface StrokeCancel {
  type: 'stroke_cancel';
  id: string;
}

/** The stroke is over; answered with a final ``stroke_result`` once it is durable. */
export interface StrokeEnd {
  type: 'stroke_end';
  id: string;
}

/** More samples of a stroke; answered with ``stroke_result``, not final. */
export interface StrokeSamples {
  type: 'stroke_samples';
  id: string;
  samples: Sample[];
}

/** Start a tracking run; its ``job`` messages follow. */
export interface Track {
  method?: string;
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

/** Take back this author's last edit; answered with a final ``stroke_result``. */
export interface Undo {
  type: 'undo';
  id: string;
}

/** Chunks of a large frame, most wanted first; replaces the previous list. */
export interface Want {
  type: 'want';
  frame: number;
  chunks: number[];
}

/**
 * Label values of a frame's points, whole (``base`` null) or as a delta from ``base``.
 *
 * A value is a label id, 0 unlabeled, or 65535 for a deleted point.
 * whole: runs over [first, first + count): ``lengths`` uint32 and ``values`` uint16, as many.
 * delta: ``lengths`` holds sorted uint32 point numbers, ``values`` one uint16 for each, or a
 * single one for all.  Who applies all of them in the order they come is always right.  ``base``
 * is no older than the last change of the frame and no newer than what the viewer has: who holds
 * the frame at a revision below it has missed something and sends ``open`` with the last revision
 * it is sure of.  The answer to that, ``sequence``, counts for all that is held: the deltas up to
 * its revision follow.
 */
export interface Annotation {
  type: 'annotation';
  sequence: string;
  frame: number;
  revision: number;
  base: number | null;
  edit: string | null;
  author: string | null;
  provisional: boolean;
  first: number;
  count: number;
  lengths: Uint8Array;
  values: Uint8Array;
}

/** An oriented box of a label: one size, and a pose in each frame that it is in. */
export interface Box {
  id: number;
  label: number;
  size: [number, number, number];
  poses: Record<string, BoxPose>;
  attributes: Record<string, string | number | boolean>;
  provenance: 'fitted' | 'drawn' | 'imported';
}

/** Place of a box in one frame; its attributes go before those of the box. */
export interface BoxPose {
  centre: [number, number, number];
  quaternion: [number, number, number, number];
  provenance: 'fitted' | 'drawn' | 'imported';
  confidence: number;
  attributes: Record<string, string | number | boolean>;
}

/**
 * Boxes that changed, as they are now, and ids of those that are gone.
 *
 * After ``open`` all there are (``whole``), and then with every edit that changes boxes.
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
 * ``id`` is opaque, and void once the frame or the clicks change; empty for the regions of other
 * shapes.  ``score``: the overlap with the object that is expected, 0..1.
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
 * ``first``: the one to show first.  ``ready``: the whole frame is prepared; else they come from
 * what is near the clicks.
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
 * A run of points, encoded with the meshoptimizer vertex codec, 12 bytes a point.
 *
 * Decoded layout: x, y, z uint16; r, g, b, intensity uint8; flags uint8; a byte zero.
 * Where bit 0 of the first vertex's flags is set, all of r and b are less g (modulo 256).
 * Bits 1 and 2 say how many low bits r, g and b have lost: value = v << n | v >> (8 - 2n); with
 * n = 3 the bytes of r and g are a little-endian word of r (lowest), g and b in 5, 6 and 5 bits.
 * Position = ``origin + q * scale``, in the sequence's local coordinates (source minus shift).
 */
export interface Chunk {
  index: number;
  level: number;
  first: number;
  count: number;
  offset: number;
  nbytes: number;
  origin: [number, number, number];
  scale: [number, number, number];
  lo: [number, number, number];
  hi: [number, number, number];
}

/**
 * Chunks of a frame as parts of a depth image, in place of ``frame``; numbers are the same.
 *
 * Sent to who said ``depth`` in ``hello``.  A chunk needs the depths of all before it.
 */
export interface Depth {
  type: 'depth';
  sequence: string;
  frame: number;
  total: number;
  final: boolean;
  chunks: DepthChunk[];
  data: Uint8Array;
}

/** A run of points that is a band of a depth image: docs/depth-format.md. */
export interface DepthChunk {
  index: number;
  level: number;
  first: number;
  count: number;
  offset: number;
  nbytes: number;
  lo: [number, number, number];
  hi: [number, number, number];
}

/** RFC 9457 fields; ``about`` is the id of the stroke, undo, track or ask refused, if any. */
export interface Error {
  type: 'error';
  title: string;
  detail: string;
  status: number;
  about: string | null;
  closed: string | null;
}

/**
 * Chunks of a frame, in stored order: a prefix, or what refines the prefix sent before.
 *
 * Of a large frame, the chunks asked for.  The ``annotation`` of these points, whole, comes just
 * before, so that they never show without their labels.
 */
export interface Frame {
  type: 'frame';
  sequence: string;
  frame: number;
  total: number;
  final: boolean;
  chunks: Chunk[];
  data: Uint8Array;
}

/** Long work and how far it is. */
export interface Job {
  type: 'job';
  id: string;
  kind: 'import' | 'tracking' | 'export' | 'prediction' | 'fitting';
  sequence: string | null;
  state: 'queued' | 'running' | 'done' | 'failed' | 'cancelled';
  progress: number;
  message: string;
  frame: number | null;
  error: string | null;
  edit: string | null;
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

/** The palette, whole; and how many points each label has in all frames together. */
export interface Labels {
  type: 'labels';
  sequence: string;
  revision: number;
  labels: Label[];
  counts: Record<string, number>;
  undo: string | null;
  redo: string | null;
}

/**
 * Pixels of a depth camera; all frames of a recording have the same.
 *
 * With a depth of d units, the point of pixel (column, row) lies d * ``unit`` metres from ``eye``
 * along ``sign`` times axis ``axis``, and (``tangent`` + ``pitch`` * pixel) times as far along the
 * other two axes: the first one with the column, the second with the row.
 */
export interface Lattice {
  width: number;
  height: number;
  axis: number;
  sign: -1 | 1;
  tangent: [number, number];
  pitch: [number, number];
  eye: [number, number, number];
  unit: number;
}

/** A frame is prepared for the object tool: what is asked of it is answered from all of it. */
export interface Prepared {
  type: 'prepared';
  sequence: string;
  frame: number;
}

/** The answer to ``open``, and sent again when the manifest changes. */
export interface SequenceInfo {
  type: 'sequence';
  id: string;
  identity: string;
  name: string;
  frames: number;
  fps: number;
  points: number[];
  fields: string[];
  shift: [number, number, number];
  lo: [number, number, number];
  hi: [number, number, number];
  room: number[];
  cameras: boolean;
  large: boolean;
  position_error: number;
  color_error: number;
  lattice: Lattice | null;
  revision: number;
  frame: number;
}

/** Place of another person; ``left``: they have gone. */
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
 * ``touched``: newly touched points so far; ``final`` once the edit is durable.
 *
 * ``changed``: those of them that the stroke changes; what the hand feels.
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

/** Cells that changed (all of them after ``open``); one without points and state goes. */
export interface Timeline {
  type: 'timeline';
  sequence: string;
  revision: number;
  whole: boolean;
  cells: TimelineCell[];
}

/** One label in one frame: how many points, where from, how sure. */
export interface TimelineCell {
  frame: number;
  label: number;
  points: number;
  painted: number;
  confidence: number | null;
  state: 'painted' | 'tracked' | 'occluded' | 'lost' | null;
}

/** The answer to ``hello``. */
export interface Welcome {
  type: 'welcome';
  viewer: string;
  author: string;
  role: 'viewer' | 'annotator' | 'reviewer' | 'manager' | 'admin';
  version: string;
  credits: number;
  account: string;
}

/** A feature that was asked for; ``granted`` is null where the browser does not tell. */
export interface HeadsetFeature {
  name: string;
  granted: boolean | null;
}

/**
 * An input source, with what was seen of it.
 *
 * ``kind`` and ``layout`` are what the page took it for, empty where it knows none; ``pressed``
 * and ``leaned`` are numbers of buttons and axes; ``joints`` is null without a hand.
 */
export interface HeadsetInput {
  side: 'left' | 'right' | 'none';
  mode: string;
  profiles: string[];
  kind: string;
  layout: string;
  buttons: number;
  axes: number;
  pressed: number[];
  leaned: number[];
  joints: number | null;
  pulses: 'hapticActuators' | 'vibrationActuator' | 'none';
}

/** The layer that is drawn into; ``foveation`` is null where the browser has none. */
export interface HeadsetLayer {
  kind: 'projection' | 'webgl';
  width: number;
  height: number;
  views: number;
  foveation: number | null;
  depth_near: number;
  depth_far: number;
}

/**
 * Times between pictures while the recording played.
 *
 * ``told`` is the display's rate as the browser tells it, ``offered`` the rates that it can be
 * asked for, ``found`` the rate that the times show; a picture is ``late`` when it misses a
 * refresh, of the rate that is told if there is one.
 */
export interface HeadsetPictures {
  told: number | null;
  offered: number[];
  found: number;
  count: number;
  median_ms: number;
  p95_ms: number;
  late: number;
}

/** The whole file; ``trouble`` is why no session began, ``session`` null as long as none did. */
export interface HeadsetReport {
  format: 'pointbrush headset report';
  version: 1;
  made: string;
  pointbrush: string;
  browser: string;
  trouble: string;
  session: HeadsetSession | null;
  inputs: HeadsetInput[];
  pictures: HeadsetPictures | null;
  tasks: HeadsetTask[];
}

/** A session as it began; ``floor``: its space knows where the floor is. */
export interface HeadsetSession {
  mode: string;
  blend: string;
  floor: boolean;
  features: HeadsetFeature[];
  spaces: HeadsetSpace[];
  layer: HeadsetLayer;
}

/** A reference space, and whether the session gives it. */
export interface HeadsetSpace {
  name: string;
  given: boolean;
}

/** A thing to do; ``by_buttons``: a button or pad of a controller did it, not a panel. */
export interface HeadsetTask {
  name: 'play' | 'felt' | 'paint' | 'erase' | 'label' | 'undo' | 'step' | 'go';
  verdict: 'works' | 'fails' | 'unknown';
  by_buttons: boolean;
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
  | Labels
  | Timeline
  | Boxes
  | Job
  | ServerPresence
  | Error;
